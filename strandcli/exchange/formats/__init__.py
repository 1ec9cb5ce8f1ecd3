"""Formats of files of strands, a module each, found by its file; `strandcli.exchange.files` says what each has."""
