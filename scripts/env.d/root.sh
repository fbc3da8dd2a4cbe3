# shellcheck shell=bash
# Making a Debian root file system: mmdebstrap, a list of packages, the machine's own mirror.
# Sourced after places.sh by scripts/env, scripts/ccx and scripts/image, which say what is made: the
# suite, the folder that it is kept in, and two functions that print lists: `packages` Debian's,
# `python_packages` those that pip installs.
: "${script:?}" "${suite:?}" "${cache:?}"

recipe=1  # raise it when start_mmdebstrap makes something else of the same list

# What runs as root of a namespace of its own may do with a root file system what root may, and its
# files belong to the ordinary user who started it (or to sub-ids of theirs, until the build is done).
as_owner=()
((UID == 0)) || as_owner=(unshare --map-root-user --map-auto)

root_folder() {
    local key
    key=$({ echo "$suite $recipe $(uname -m)"; packages; python_packages; } | sha256sum | cut -c1-12)
    echo "$cache/root-$key"
}

# The folder gets its name when it is whole, so its being there is enough.
root_is_built() {
    [[ -d $(root_folder) ]]
}

# One process builds at a time, holding the lock.
with_build_lock() {  # command...
    local lock
    need_command bwrap bubblewrap
    need_command mmdebstrap mmdebstrap
    need_namespaces
    make_cache
    exec {lock}>"$cache/lock"
    if ! flock --nonblock "$lock"; then
        echo "$script: another start is making the environment, waiting for it" >&2
        flock "$lock"
    fi
    "$@"
    exec {lock}>&-
}

need_namespaces() {
    local said
    said=$(bwrap --dev-bind / / true 2>&1) || fail 1 "bubblewrap is kept from its work: $(refusal "$said")"
    ((UID == 0)) || need_command newuidmap uidmap
    said=$("${as_owner[@]}" true 2>&1) ||
        fail 1 "the user $(id -un) may not make a root file system here: ${said:-no user namespaces}; root can allow it with: usermod --add-subuids FIRST-LAST --add-subgids FIRST-LAST $(id -un) (65536 ids that nobody else has)"
}

# Ubuntu 23.10 and later let AppArmor keep ordinary users' programs from making user namespaces.
refusal() {  # bubblewrap's own words
    local setting=/proc/sys/kernel/apparmor_restrict_unprivileged_userns found= said=${1//$'\n'/ }
    [[ ! -r $setting ]] || found=" (here it is $(<"$setting"))"
    echo "it may not make mounts or user namespaces here. It says: ${said:-nothing}." \
        "Where AppArmor forbids it (kernel.apparmor_restrict_unprivileged_userns = 1$found, the" \
        "default of Ubuntu from 23.10 on), root allows it by an AppArmor profile with 'userns,' for" \
        "$(type -P bwrap), or by: sysctl kernel.apparmor_restrict_unprivileged_userns=0. In a" \
        "container without that right take Debian 13 with the packages of docker/apt-packages.txt," \
        "or the Docker image"
}

build_root_unless_built() {
    root_is_built || build_root
}

build_root() {
    local root partial log=$cache/build.log screen progress builder
    root=$(root_folder)
    partial=$root.partial
    clear_remains
    echo "$script: making a Debian $suite environment in $root (once, a few minutes)" >&2
    exec {screen}> >(show_progress "$log")
    progress=$!
    start_mmdebstrap "$partial" >&"$screen" 2>&1 {screen}>&- &
    builder=$!
    exec {screen}>&-
    # shellcheck disable=SC2064
    trap "kill -KILL $builder; wait $builder 2>/dev/null; exit 130" INT
    # shellcheck disable=SC2064
    trap "kill -KILL $builder; wait $builder 2>/dev/null; exit 143" TERM HUP
    trap clear_remains EXIT
    wait "$builder" || fail 1 "making the environment failed: $(cause_of_failure "$log") (all of it: $log)"
    wait "$progress"
    # All of it is the ordinary user's now, who can remove it as any other folder.
    ((UID == 0)) || "${as_owner[@]}" chown --recursive --no-dereference 0:0 "$partial"
    install_python_packages "$partial" "$log"
    sync --file-system "$partial"
    [[ ! -e $root ]] || mv --no-target-directory "$root" "$root.old-$$.partial"
    mv --no-target-directory "$partial" "$root"
    trap - INT TERM HUP EXIT
    clear_remains
    remove_other_roots "$root"
    rm -rf "$cache/packages" "$log"
    echo "$script: the environment is ready ($(du -sh "$root" 2>/dev/null | cut -f1), ${SECONDS} s)" >&2
}

# pip runs in the new root, with the settings of this machine's own (see `view_of`). Debian's Python
# finds the packages beside Debian's; /usr/local is the machine's while a command runs. Without them
# everything else still works, so a machine that reaches no package index gets a root all the same.
install_python_packages() {  # root, log
    local root=$1 log=$2 into=/usr/lib/python3/dist-packages list enter view=()
    list=$(python_packages)
    [[ -n $list ]] || return 0
    show_stage "installing Python packages"
    mapfile -d '' -t view < <(view_of "$root")
    enter=$(type -P bwrap)
    (
        set_root_variables "$root"
        "$enter" "${view[@]}" --bind "$root$into" "$into" -- /usr/bin/python3 -m pip install \
            --no-deps --only-binary :all: --no-cache-dir --target "$into" \
            --requirement /dev/stdin <<<"$list"
    ) >>"$log" 2>&1 ||
        echo "$script: not installed: ${list//$'\n'/, } ($(pip_error "$log")); all else works, scripts/env --rebuild tries again" >&2
}

pip_error() {  # log
    grep '^ERROR: ' "$1" | tail -n 1 | grep . || tail -n 1 "$1"
}

# Under the lock, a temporary name is the remains of a broken build: what it downloaded is kept.
clear_remains() {
    local partial
    for partial in "$cache"/root-*.partial; do
        [[ -d $partial ]] || continue
        mkdir -p "$cache/packages"
        "${as_owner[@]}" find "$partial/var/cache/apt/archives" -maxdepth 1 -name '*.deb' \
            -exec mv --target-directory="$cache/packages" {} + 2>/dev/null || true
        remove_unless_in_use "$partial" || { sleep 1 && remove_unless_in_use "$partial"; } || true
    done
}

remove_other_roots() {  # the root to keep
    local root
    for root in "$cache"/root-*; do
        [[ $root == "$1" ]] || remove_unless_in_use "$root" || true
    done
}

# Every command started in a root holds a shared lock on it; what is in use goes another time. It also
# fails where a process that was just killed still writes.
remove_unless_in_use() {  # folder
    flock --exclusive --nonblock "$1" "${as_owner[@]}" rm -rf --one-file-system "$1" 2>/dev/null
}

start_mmdebstrap() {  # folder to make
    # shellcheck disable=SC2016
    run_mmdebstrap "$1" --verbose --variant=apt --format=directory \
        --include="$(packages | paste -sd,)" \
        --setup-hook='mkdir -p "$1/var/cache/apt/archives"' \
        --setup-hook="find ${cache@Q}/packages -name '*.deb' -exec cp --target-directory=\"\$1/var/cache/apt/archives\" {} + 2>/dev/null || true" \
        --customize-hook='rm -f "$1"/var/cache/apt/archives/*.deb "$1"/etc/apt/apt.conf.d/99mmdebstrap' \
        --customize-hook='cd "$1/etc" && rm -f localtime dpkg/dpkg.cfg.d/99mmdebstrap && touch localtime pip.conf hosts hostname resolv.conf'
}

# Runs as the process that it replaces. mmdebstrap gets its own mounts and process ids, so that
# killing it leaves neither mounts nor processes, and dies with the start that it belongs to. Nothing
# need be on the disk before the end, so dpkg does not wait for every file.
run_mmdebstrap() {  # what to make, options...
    local target=$1 alone sources
    shift
    mapfile -t sources < <(debian_sources)
    alone=(setpriv --pdeathsig KILL "${as_owner[@]:-unshare}" --mount --pid --mount-proc --fork --kill-child)
    exec "${alone[@]}" mmdebstrap --mode=root --aptopt="$(apt_settings)" --dpkgopt=force-unsafe-io "$@" \
        "$suite" "$target" "${sources[@]}" </dev/null
}

# One line of apt's for each part of the suite that the machine has the counterpart of, from the same
# mirror; nothing where the machine has no Debian mirror: mmdebstrap then takes its own default.
debian_sources() {
    local uri index _ suite_here suite_there signed=
    local keyring=/usr/share/keyrings/debian-archive-keyring.gpg
    [[ ! -e $keyring ]] || signed="[signed-by=$keyring] "
    while read -r uri index _; do
        [[ $uri == *:*/dists/*/InRelease\' ]] || continue
        is_debian "$uri" "$index" || continue
        suite_here=${uri##*/dists/} suite_here=${suite_here%/InRelease\'}
        uri=${uri%%/dists/*} uri=${uri#\'}
        case $suite_here in
            *-backports* | *-proposed-updates | experimental) continue ;;
            *-security | */updates) suite_there=$suite-security ;;
            *-updates) suite_there=$suite-updates ;;
            *) suite_there=$suite ;;
        esac
        [[ $suite_there == unstable* && $suite_there != unstable ]] && continue  # it has neither
        echo "deb $signed$uri $suite_there main"
    done < <(apt-get update --print-uris 2>/dev/null) | sort -u
}

# As the mirror's own index says; by its address where apt has not fetched the index yet.
is_debian() {  # address, name of the index
    local release=/var/lib/apt/lists/$2
    if [[ -r $release ]]; then
        grep -q '^Origin: Debian$' "$release"
    else
        [[ $1 == */debian/dists/* || $1 == */debian-security/dists/* ]] && [[ $1 != */linux/debian/* ]]
    fi
}

# How the machine's own apt reaches its mirrors: proxies, certificates, passwords, retries, dates.
apt_settings() {
    apt-config dump --format '%f "%v";%n' Acquire 2>/dev/null |
        grep -E '^Acquire::(https?::.*|Retries|Check-Date|Check-Valid-Until|ForceIPv[46]) ".+";$' || true
    # A mirror may lag behind the few days for which these suites' index is valid.
    case $suite in testing | unstable) echo 'Acquire::Check-Valid-Until "false";' ;; esac
    echo 'Dir::Etc::netrc "/etc/apt/auth.conf"; Dir::Etc::netrcparts "/etc/apt/auth.conf.d";'
}

# The only packages of the machine that are ever touched: one that is missing is installed where that is ours to do.
need_command() {  # command, its package
    ! command -v "$1" >/dev/null || return 0
    if ((UID != 0)) || ! command -v apt-get >/dev/null; then
        fail 1 "$2 is missing, which the environment with dolfinx needs here; install it: apt-get install $2"
    fi
    echo "$script: installing $2" >&2
    apt_install "$2" || fail 1 "$2 could not be installed; try it by hand: apt-get install $2"
}

apt_install() {
    local -a install=(apt-get install --yes --quiet --quiet --no-install-recommends "$@")
    export DEBIAN_FRONTEND=noninteractive
    "${install[@]}" >/dev/null 2>&1 || { apt-get update --quiet --quiet && "${install[@]}"; } >/dev/null
}

# The first error names the cause; those after it say what else failed because of it. dpkg's other
# lines are warnings.
cause_of_failure() {  # log
    grep --max-count=1 -E '^(E:|dpkg: error) ' "$1" || tail -n 1 "$1"
}

# mmdebstrap's and apt's many lines: all of them into the log, and on the screen where it stands.
show_progress() {  # log
    local line total='?'
    local -A count=()
    while IFS= read -r line; do
        printf '%s\n' "$line" >&3
        case $line in
            *" newly installed, "*) total=${line#*, } total=${total%% newly*} count=() ;;
            "I: running apt-get update"*) show_stage "reading the package index" ;;
            Get:*" Packages "* | Get:*" InRelease "*) ;;
            Get:*) show_count downloading ;;
            Unpacking*) show_count unpacking ;;
            "Setting up"*) show_count "setting up" ;;
            "I: cleaning package lists"*) show_stage "cleaning up" ;;
        esac
    done 3>"$1"
    [[ ! -t 2 ]] || printf '\r\033[K' >&2
}

show_stage() {  # what is being done
    if [[ -t 2 ]]; then
        printf '\r\033[K%s (%s s)' "$1" "$SECONDS" >&2
    else
        echo "$script: $1 (${SECONDS} s)" >&2
    fi
}

# One line that changes on a terminal; else a line for the first and every hundredth package.
show_count() {  # what is being done to one more package; uses the caller's count and total
    count[$1]=$((${count[$1]:-0} + 1))
    if [[ -t 2 ]] || ((count[$1] % 100 == 1)); then
        show_stage "$1 packages: ${count[$1]} of $total"
    fi
}
