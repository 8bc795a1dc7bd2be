# For scripts of this folder, which read it: a folder to work in that goes with the script, and steps that speak where they
# fail. $python is a Python, $root or $sources the checkout.
unset PYTHONPATH PYTHONHOME PIP_TARGET PIP_PREFIX PIP_ROOT
export PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_USER=0

work=$(mktemp -d)
trap 'rm -rf --one-file-system "$work"' EXIT
trap 'exit 130' INT TERM HUP

# Does a step. What it says is shown where it fails, without the lines that call a compiler.
step() { # WHAT WORDS...
    what=$1
    shift
    "$@" >"$work/said" 2>&1 || {
        grep -vE '^ *[^ ]+ .* -c [^ ]+ -o ' "$work/said" | tail -n 40
        echo "hil: not built, $what: $("$python" "${sources:-$root}/packaging/build_venv.py" --cause "$work/said") ($*)"
        exit 1
    } >&2
}

# Waits until no other build goes on in the checkout, which is $root, and has to be one that can be written.
alone() {
    [ -w "$root" ] || {
        echo "hil: not built, $root cannot be written: build in a clone of your own" >&2
        exit 1
    }
    exec 9<"$root/packaging/build_venv.py"
    flock -n 9 2>/dev/null || {
        echo "Another build runs in $root: this one waits for its end."
        flock 9
    }
}
