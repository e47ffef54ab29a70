#compdef pirate pirate-run
# Completes the command lines of pirate and pirate-run in zsh.
_pirate_sm() {
    local value about shown
    local -a complete open
    while IFS=$'\t' read -r value about; do
        shown=${${value//\\/\\\\}//:/\\:}${about:+:$about}
        case $value in
            *[/=:,]) open+=("$shown") ;;
            *) complete+=("$shown") ;;
        esac
    done < <(
        PIRATE_SM_COMPLETE=zsh PIRATE_SM_LINE="${(j: :)words[1,CURRENT-1]} $PREFIX" \
            ${~words[1]} 2>/dev/null </dev/null
    )
    _describe -V value complete -- open -S ''
}
if (( ! $+functions[compdef] )); then
    autoload -Uz compinit
    compinit -i
fi
compdef _pirate_sm pirate pirate-run
