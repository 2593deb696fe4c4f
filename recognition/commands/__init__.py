"""One file a command: parse, call, print.  Whatever is not needed to parse is imported when it is called."""
