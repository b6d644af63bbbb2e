"""Run the command line as `python -m gimcli`."""

from gimcli.cli import main

if __name__ == "__main__":
    main()
