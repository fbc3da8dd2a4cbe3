#!/bin/bash
# A study on the ranks of one job: groups of ranks take the next case from one queue.
#   sbatch scripts/slurm/mpirun.sh study.toml study
# A job that is cut off by its time limit is submitted again: it goes on where it was.
#SBATCH --job-name=bilayer-study
#SBATCH --nodes=1
#SBATCH --ntasks=16
#SBATCH --mem-per-cpu=2G
#SBATCH --time=08:00:00
#SBATCH --output=bilayer-study-%j.log
set -euo pipefail

study=${1:?the study file} folder=${2:?the folder of the study}
ranks_per_case=${3:-1}
# Slurm runs a copy of this file, so the checkout is named by the folder of the submission.
checkout=${BILAYER_CHECKOUT:-$SLURM_SUBMIT_DIR}

"$checkout/scripts/env" mpirun -n "$SLURM_NTASKS" \
    bilayer study "$study" -o "$folder" --ranks-per-case "$ranks_per_case" --quiet
