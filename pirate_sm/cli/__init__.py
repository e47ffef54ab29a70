"""The command line: options, commands, output, exit codes."""
