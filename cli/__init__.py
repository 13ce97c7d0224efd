"""The command line: one command a file, each parses, calls one pipeline or report, and prints."""
