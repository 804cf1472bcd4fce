"""`python -m thermo` is the `thermo` command."""

from thermo.app import main

if __name__ == "__main__":
    main()
