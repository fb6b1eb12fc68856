"""The command line: `d3pg`."""
