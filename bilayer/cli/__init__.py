"""The command line: the parser, and a module a verb."""
