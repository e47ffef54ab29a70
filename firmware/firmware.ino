// The Arduino program wants a file of this name. Everything begins in src/mega.cpp; docs/firmware.md
// says how it is built, flashed and wired.
