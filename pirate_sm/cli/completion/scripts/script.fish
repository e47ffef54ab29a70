# Completes the command lines of pirate and pirate-run in fish.
function __pirate_sm
    set -l words (commandline -opc)
    env PIRATE_SM_COMPLETE=fish PIRATE_SM_LINE=(commandline -cp) $words[1] 2>/dev/null </dev/null
end
for program in pirate pirate-run
    complete --command $program --no-files --keep-order --arguments '(__pirate_sm)'
end
