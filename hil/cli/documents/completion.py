"""``hil completion``: scripts with which shells complete the command line.

Commands and options stand in the script, so that they cost nothing; names of what runs come from
``hil _names`` (``completion_names.py``) when the key is pressed.
"""

from hil.cli.documents.command_tree import CliCommand, CliParameter
from hil.cli.framework.command_table import FILE, FOLDER

BASH = r"""
_hil_offer() {
    local word
    while IFS=$'\t' read -r word _; do
        [[ $word == "$1"* ]] && COMPREPLY+=("$word")
    done
}

_hil() {
    local current=${COMP_WORDS[COMP_CWORD]} path=hil expected='' position=0 word i
    COMPREPLY=()
    for ((i = 1; i < COMP_CWORD; i++)); do
        word=${COMP_WORDS[i]}
        if [[ $word == = ]]; then continue # bash splits words there
        elif [[ $expected ]]; then expected=''
        elif [[ $word == -* ]]; then expected=${_hil_takes["$path $word"]-}
        elif [[ " ${_hil_commands[$path]-} " == *" $word "* ]]; then path+=" $word"
        else ((++position)); fi
    done
    [[ $current == = ]] && current=''
    if [[ ! $expected ]]; then
        if [[ $current == -* ]]; then
            _hil_offer "$current" < <(printf '%s\n' ${_hil_options[$path]-})
            return
        elif [[ ${_hil_commands[$path]-} ]] && ((!position)); then
            _hil_offer "$current" < <(printf '%s\n' ${_hil_commands[$path]})
        fi
        local arguments=(${_hil_arguments[$path]-}) count
        count=${#arguments[@]}
        ((count && position >= count)) && [[ ${arguments[count - 1]} == *+ ]] && position=$((count - 1))
        expected=${arguments[position]-}
        expected=${expected%+}
    fi
    case $expected in
        '' | -) ;;
        file) compopt -o filenames; mapfile -tO ${#COMPREPLY[@]} COMPREPLY < <(compgen -f -- "$current") ;;
        folder) compopt -o filenames; mapfile -tO ${#COMPREPLY[@]} COMPREPLY < <(compgen -d -- "$current") ;;
        *)
            [[ $expected == *-values ]] && compopt -o nospace
            _hil_offer "$current" < <("$1" _names "$expected" "${COMP_WORDS[@]:1:COMP_CWORD-1}" 2>/dev/null)
            ;;
    esac
}

complete -F _hil hil
"""

ZSH = r"""
__hil_names() {
    local kind=$1 row
    local -a names more
    for row in "${(@f)$($_hil_words[1] _names $kind $_hil_words[2,-1] 2>/dev/null)}"; do
        [[ -n $row ]] && names+=("${${row%%$'\t'*}//:/\\:}:${row#*$'\t'}")
    done
    [[ $kind == *-values ]] && more=(-S '')
    _describe -t $kind $kind names "${more[@]}"
}

__hil_below() {
    case $state in
        command)
            _describe -t commands command commands
            (( $+functions[__alone$1] )) && __alone$1
            ;;
        rest)
            if (( $+functions[$1_$line[1]] )); then
                $1_$line[1]
            elif (( $+functions[__alone$1] )); then
                words=(hil $words)
                (( ++CURRENT ))
                __alone$1
            fi
            ;;
    esac
}

_hil() {
    local -a _hil_words=("${(@)words[1,CURRENT-1]}")
    _hil_
}

# Found by its name in $fpath, or sourced.
if [[ $funcstack[1] == _hil ]]; then _hil "$@"; else compdef _hil hil; fi
"""

FISH = r"""
function __hil_state --description 'The command so far, and how many words follow it'
    set -l words (commandline -opc)
    set -l path
    set -l count 0
    set -l skip 0
    for word in $words[2..]
        if test $skip = 1
            set skip 0
        else if string match -q -- '-*' $word
            contains -- "$path $word" $__hil_valued; and set skip 1
        else if contains -- (string trim -- "$path $word") $__hil_paths
            set path (string trim -- "$path $word")
        else
            set count (math $count + 1)
        end
    end
    echo $path
    echo $count
end

function __hil_in
    set -l state (__hil_state)
    test "$state[1]" = "$argv[1]"
end

function __hil_at
    set -l state (__hil_state)
    test "$state[1]" = "$argv[1]"; and test $state[2] $argv[2] $argv[3]
end

function __hil_names
    set -l words (commandline -opc)
    $words[1] _names $argv[1] $words[2..] 2>/dev/null
end

complete -c hil -e
complete -c hil -f
"""


def bash(root: CliCommand) -> str:
    """Write the script for bash: tables for the function above."""
    tables: dict[str, list[str]] = {"commands": [], "options": [], "takes": [], "arguments": []}
    for command in root.all():
        path = " ".join(("hil", *command.path))
        flags = [flag for option in command.options for flag in option.flags]
        tables["options"].append(f"[{_quoted(path)}]={_quoted(' '.join(flags))}")
        if command.commands:
            names = " ".join(each.path[-1] for each in command.commands)
            tables["commands"].append(f"[{_quoted(path)}]={_quoted(names)}")
        if command.arguments:
            kinds = " ".join((each.takes or "-") + "+" * each.is_repeated for each in command.arguments)
            tables["arguments"].append(f"[{_quoted(path)}]={_quoted(kinds)}")
        for option in command.options:
            for flag in option.flags if option.takes_value else ():
                tables["takes"].append(f"[{_quoted(f'{path} {flag}')}]={_quoted(option.takes or '-')}")
    parts = [
        f"declare -gA _hil_{name}=(\n    " + "\n    ".join(rows) + "\n)" for name, rows in tables.items()
    ]
    return "# bash completion of hil\n" + "\n".join(parts) + "\n" + BASH


def zsh(root: CliCommand) -> str:
    """Write the script for zsh: a function for each command."""
    return "\n".join(["#compdef hil\n", *(_zsh_function(each) for each in root.all())]) + ZSH


def _zsh_function(command: CliCommand) -> str:
    specs = [_zsh_option(option) for option in command.options]
    for place, argument in enumerate(command.arguments, 1):
        where = "*" if argument.is_repeated else str(place)
        specs.append(_quoted(f"{where}:{_zsh_text(argument.name)}:{_zsh_action(argument)}"))
    below = "_".join(("_hil", *command.path))
    name = below if command.path else "_hil_"
    alone = "() {\n    _arguments -S \\\n        " + " \\\n        ".join(specs) + "\n}\n"
    if not command.commands:
        return name + alone
    alone = f"__alone{name}{alone}\n" if command.arguments else ""
    specs = [*map(_zsh_option, command.options), "'1: :->command'", "'*:: :->rest'"]
    rows = [_quoted(f"{each.path[-1]}:{each.summary}") for each in command.commands]
    return (
        f"{alone}{name}() {{\n    local context state state_descr line\n    typeset -A opt_args\n"
        + "    local -a commands=(\n        "
        + "\n        ".join(rows)
        + "\n    )\n"
        + "    _arguments -C -S \\\n        "
        + " \\\n        ".join(specs)
        + f"\n    __hil_below {below}\n}}\n"
    )


def _zsh_option(option: CliParameter) -> str:
    value = f":{_zsh_text(option.name)}:{_zsh_action(option)}" if option.takes_value else ""
    again = "*" if option.is_repeated else ""
    rows = []
    for flag in option.flags:
        equals = "=" if option.takes_value and flag.startswith("--") else ""
        others = "" if option.is_repeated else f"({' '.join(option.flags)})"
        rows.append(_quoted(f"{others}{again}{flag}{equals}[{_zsh_text(option.about)}]{value}"))
    return " ".join(rows)


def _zsh_action(parameter: CliParameter) -> str:
    return {FILE: "_files", FOLDER: "_files -/", "": " "}.get(
        parameter.takes, f" __hil_names {parameter.takes}"
    )


def _zsh_text(text: str) -> str:
    for sign in "\\[]:":
        text = text.replace(sign, "\\" + sign)
    return text


def fish(root: CliCommand) -> str:
    """Write the script for fish: a line for each command, option and argument."""
    every = list(root.all())
    valued = [
        _quoted(f"{command.name} {flag}")
        for command in every
        for option in command.options
        for flag in (option.flags if option.takes_value else ())
    ]
    paths = [_quoted(command.name) for command in every if command.path]
    lines = ["# fish completion of hil", f"set -g __hil_valued {' '.join(valued)}"]
    lines += [f"set -g __hil_paths {' '.join(paths)}", FISH]
    for command in every:
        for below in command.commands:
            lines.append(
                _fish_line(f"__hil_at {_quoted(command.name)} -eq 0", f"-a {below.path[-1]}", below.summary)
            )
        for option in command.options:
            flags = " ".join(
                f"-l {flag[2:]}" if flag.startswith("--") else f"-s {flag[1:]}" for flag in option.flags
            )
            lines.append(
                _fish_line(f"__hil_in {_quoted(command.name)}", flags + _fish_value(option), option.about)
            )
        for place, argument in enumerate(command.arguments):
            if argument.takes:
                count = f"-ge {place}" if argument.is_repeated else f"-eq {place}"
                condition = f"__hil_at {_quoted(command.name)} {count}"
                lines.append(_fish_line(condition, _fish_value(argument).strip(), ""))
    return "\n".join(lines) + "\n"


def _fish_line(condition: str, what: str, about: str) -> str:
    described = f" -d {_fish_quoted(about)}" if about else ""
    return f"complete -c hil -n {_fish_quoted(condition)} {what}{described}"


def _fish_value(parameter: CliParameter) -> str:
    if not parameter.takes_value:
        return ""
    return {
        FILE: " -r -F",
        FOLDER: " -x -a '(__fish_complete_directories)'",
        "": " -x",
    }.get(parameter.takes, f" -x -a '(__hil_names {parameter.takes})'")


def _quoted(text: str) -> str:
    return "'" + text.replace("'", "'\\''") + "'"


def _fish_quoted(text: str) -> str:
    return "'" + text.replace("\\", "\\\\").replace("'", "\\'") + "'"


SHELLS = {"bash": bash, "zsh": zsh, "fish": fish}
"""Writers of scripts by shell, from the tree of commands."""
