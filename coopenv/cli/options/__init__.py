"""Options of the command line: what is given, files of options, help, completion."""
