"""The command line: what it reads, what it shows, what it answers to the shell."""
