# Completes the command lines of pirate and pirate-run in bash.
_pirate_sm() {
    local each
    COMPREPLY=()
    while IFS= read -r each; do
        COMPREPLY+=("$each")
    done < <(
        PIRATE_SM_COMPLETE=bash PIRATE_SM_LINE="${COMP_LINE:0:COMP_POINT}" \
            PIRATE_SM_BREAKS="$COMP_WORDBREAKS" "${1/#\~/$HOME}" 2>/dev/null </dev/null
    )
}
complete -o nospace -F _pirate_sm pirate pirate-run
