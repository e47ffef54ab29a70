#compdef pirate pirate-run
# Completes the command lines of pirate and pirate-run in zsh.
_pirate_sm() {
    local value about shown home
    local line="${(j: :)words[1,CURRENT-1]} $PREFIX"
    local -a complete open
    # What follows is inserted with backslashes, which a ~ must not get.
    if [[ $PREFIX == \~*/* ]]; then
        home=${(Q)PREFIX%/*}/
        compset -P '*/'
    fi
    while IFS=$'\t' read -r value about; do
        value=${value#$home}
        shown=${${value//\\/\\\\}//:/\\:}${about:+:$about}
        case $value in
            *[/=:,]) open+=("$shown") ;;
            *) complete+=("$shown") ;;
        esac
    done < <(
        PIRATE_SM_COMPLETE=zsh PIRATE_SM_LINE="$line" ${~words[1]} 2>/dev/null </dev/null
    )
    _describe -V value complete -- open -S ''
}
if (( ! $+functions[compdef] )); then
    autoload -Uz compinit
    compinit -i
fi
compdef _pirate_sm pirate pirate-run
