#!/bin/bash
# A study as a job array: every task computes one case, so cases wait for one another nowhere.
#   bilayer study study.toml -o study --dry-run     # says how many cases there are
#   sbatch --array=1-60 scripts/slurm/job_array.sh study.toml study
# When all have ended, the index: bilayer study study.toml -o study
#SBATCH --job-name=bilayer-study
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --mem=2G
#SBATCH --time=01:00:00
#SBATCH --output=bilayer-study-%A_%a.log
set -euo pipefail

study=${1:?the study file} folder=${2:?the folder of the study}
# Slurm runs a copy of this file, so the checkout is named by the folder of the submission.
checkout=${BILAYER_CHECKOUT:-$SLURM_SUBMIT_DIR}

"$checkout/scripts/env" bilayer study "$study" -o "$folder" --case "$SLURM_ARRAY_TASK_ID" --quiet
