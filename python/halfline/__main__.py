"""`python -m halfline` is the command."""

from halfline._command import main

main()
