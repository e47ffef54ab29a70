"""Control panels: MIDI controllers with buttons for the stop, commands, words and answers."""
