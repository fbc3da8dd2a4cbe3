# shellcheck shell=bash
# The folders that the scripts keep things in. Sourced by every script that keeps something.
: "${script:?}"

fail() {  # status, message
    echo "$script: $2" >&2
    exit "$1"
}

# Without HOME, as in systemd units, `env -i` and `sbatch --export=NONE`, bash knows the home folder of
# the password file.
if [[ -z ${HOME:-} ]]; then
    unset HOME
    HOME=~
    export HOME
fi

# A relative path of the cache is not valid (XDG Base Directory Specification): it would be another
# folder at every start.
[[ ${XDG_CACHE_HOME:-} == /* ]] || unset XDG_CACHE_HOME
cache=${XDG_CACHE_HOME:-$HOME/.cache}/bilayer-shells

make_cache() {
    local said
    said=$(mkdir -p "$cache" 2>&1 && [[ -w $cache ]]) ||
        fail 1 "nothing can be kept in $cache (${said:-no permission to write}); set XDG_CACHE_HOME to a folder that can be written"
}
