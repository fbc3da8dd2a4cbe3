# shellcheck shell=bash
# Entering a root file system: /usr, /etc and /var are that Debian's, everything else is the
# machine's own, at its own path. Sourced by scripts/env and scripts/ccx.
: "${script:?}" "${checkout:?}"

# Bubblewrap makes the view and a process that holds it open; nsenter joins the view and becomes
# COMMAND. So COMMAND has the process id and the terminal of the script: signals reach it, and its
# exit status is ours.
enter_root() {  # root, command...
    local root=$1 here=$PWD holder lock view=()
    local -a join
    shift
    [[ $here -ef . ]] || fail 2 "the current folder $here is gone: expected one that is there"
    need_command bwrap bubblewrap
    join=("$(type -P nsenter)" --mount)
    ((UID == 0)) || join+=(--user --preserve-credentials)
    exec {lock}<"$root"
    flock --shared "$lock"  # inherited by COMMAND: its root is not removed while it runs
    mapfile -d '' -t view < <(view_of "$root")
    # A pipe, not `read < <(...)` and a wait for it: bash 5.2 may have reaped that child already, and
    # the wait then fails.
    # shellcheck disable=SC2016
    holder=$({ bwrap "${view[@]}" -- /bin/sh -c 'echo $$; exec sleep 60' {lock}<&- 2>/dev/null & } | head -n 1)
    [[ -n $holder ]] || fail_to_enter "$root"
    set_root_variables "$root"
    # shellcheck disable=SC2016
    exec "${join[@]}" --target "$holder" /bin/sh -c '
        kill "$1"
        cd -- "$2" || exit 1
        shift 2
        exec "$@"' "$script" "$holder" "$here" "$@"
}

# The same again, for what bubblewrap says.
fail_to_enter() {  # root; uses the caller's view
    local said
    said=$(bwrap --dev-bind / / true 2>&1) || fail 1 "bubblewrap could not enter $1: $(refusal "$said")"
    said=$(bwrap "${view[@]}" -- /bin/true 2>&1) || true
    fail 1 "bubblewrap could not enter $1: ${said//$'\n'/ }"
}

# Bubblewrap's arguments, each ended by a NUL.
view_of() {  # root
    local root=$1 entry folder
    for entry in "$root"/{bin,sbin,lib,lib32,lib64,libx32}; do
        [[ ! -L $entry ]] || printf '%s\0' --symlink "$(readlink "$entry")" "${entry#"$root"}"
    done
    # /usr/local and /var stay open for what the machine keeps there.
    for entry in "$root"/usr/*; do
        [[ $entry == */local ]] || printf '%s\0' --ro-bind "$entry" "${entry#"$root"}"
    done
    printf '%s\0' --ro-bind "$root/etc" /etc --ro-bind "$root/var/lib/dpkg" /var/lib/dpkg
    for entry in /*; do
        case $entry in
            /usr | /etc | /var | /bin | /sbin | /lib | /lib32 | /lib64 | /libx32) ;;
            *) if [[ -L $entry ]]; then
                printf '%s\0' --symlink "$(readlink "$entry")" "$entry"
            elif [[ -d $entry ]]; then
                printf '%s\0' --dev-bind "$entry" "$entry"
            fi ;;
        esac
    done
    for folder in /var/tmp "${TMPDIR:-}" "$HOME" "$checkout" "$PWD" "$(pwd -P)"; do
        case $folder in
            /usr/local/* | /var/*) [[ ! -d $folder ]] || printf '%s\0' --bind "$folder" "$folder" ;;
        esac
    done
    for entry in "${etc_of_the_machine[@]}"; do
        [[ ! -e $entry || ! -f $root$entry || -L $root$entry ]] ||
            printf '%s\0' --ro-bind "$(readlink -f "$entry")" "$entry"
    done
    # A file written where the machine has no folder shows as an error, not as a lost file.
    printf '%s\0' --remount-ro /
}

# The machine's own users, names, network, certificates and package index settings.
etc_of_the_machine=(
    /etc/passwd /etc/group /etc/hostname /etc/hosts /etc/resolv.conf /etc/localtime
    /etc/pip.conf /etc/ssl/certs/ca-certificates.crt
)

set_root_variables() {  # root
    local name
    # Paths of the machine's own compilers, libraries and Pythons mean nothing inside.
    for name in PYTHONHOME PYTHONPATH VIRTUAL_ENV CONDA_PREFIX LD_LIBRARY_PATH LD_PRELOAD \
        PETSC_DIR PETSC_ARCH SLEPC_DIR OPAL_PREFIX CC CXX CPP CFLAGS CXXFLAGS CPPFLAGS LDFLAGS \
        CPATH LIBRARY_PATH PKG_CONFIG_PATH "${!PYENV_@}"; do
        unset "$name"
    done
    export PATH=/usr/bin:/bin:/usr/sbin:/sbin
    export PYTHONNOUSERSITE=1  # compiled packages of the home folder are for another Python
    export LANG=C.UTF-8 LC_ALL=C.UTF-8  # the only locale inside
    # MPI within this machine alone: shared memory, no search for fast networks and their warnings.
    export OMPI_MCA_pml=${OMPI_MCA_pml:-ob1} OMPI_MCA_btl=${OMPI_MCA_btl:-self,sm}
    set_common_variables "$1"
}

# What holds in every way: the checkout's package and commands are found, one thread per rank, and
# mpirun may start more ranks than there are cores.
# scripts/ comes last on the PATH, because its `env` and `test` must not hide the system's.
# A nested call finds BILAYER_ENV=native and so runs its command directly.
set_common_variables() {  # root, or nothing for this machine's own
    local more_ranks_than_cores seen
    more_ranks_than_cores=$(name_of_mapping_policy "$1")
    seen=$(path_without_colon "$checkout")
    take_a_temporary_folder
    export BILAYER_ENV=native
    [[ :$PATH: == *:$seen/scripts:* ]] || export PATH=$PATH:$seen/scripts
    [[ :${PYTHONPATH-}: == *:$seen:* ]] || export PYTHONPATH=$seen${PYTHONPATH:+:$PYTHONPATH}
    export OMP_NUM_THREADS=${OMP_NUM_THREADS:-1} OPENBLAS_NUM_THREADS=${OPENBLAS_NUM_THREADS:-1}
    export "$more_ranks_than_cores=${!more_ranks_than_cores:-:oversubscribe}"
    if ((UID == 0)); then
        export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
    fi
}

# PATH and PYTHONPATH have no way to write a colon: a link without one stands for such a folder.
path_without_colon() {  # folder
    local link
    [[ $1 == *:* ]] || { echo "$1"; return; }
    link=$cache/checkouts/$(sha256sum <<<"$1" | cut -c1-12)
    [[ $link != *:* ]] ||
        fail 2 "neither $1 nor $cache may have a colon in its name, which PATH cannot hold; set XDG_CACHE_HOME to a folder without one"
    make_cache
    mkdir -p "${link%/*}"
    [[ $link -ef $1 ]] || ln --symbolic --force --no-dereference "$1" "$link"
    echo "$link"
}

# MPI ends in a segmentation violation where its temporary folder is gone, as it is in a shell that
# outlived its batch job.
take_a_temporary_folder() {
    [[ -n ${TMPDIR:-} ]] || return 0
    [[ -d $TMPDIR && -w $TMPDIR && -x $TMPDIR ]] && return
    echo "$script: TMPDIR = $TMPDIR is no folder that can be written; /tmp is taken" >&2
    unset TMPDIR
}

# Open MPI 6 has another name for it, and complains of the one before.
name_of_mapping_policy() {  # root
    if compgen -G "$1/usr/lib/*/libprrte.so.5" >/dev/null; then
        echo PRTE_MCA_mapby
    else
        echo PRTE_MCA_rmaps_default_mapping_policy
    fi
}
