"""Attacks of our own against a walking hoist: attack.py BIN [--only RE] [--minutes N]. See deploy/verbs/attack.sh and README.md."""
import argparse
import sys

import ground
import http_attacks  # noqa: F401  (registers its attacks)
import socket_attacks  # noqa: F401
import driving_attacks  # noqa: F401
import people_attacks  # noqa: F401
import program_attacks  # noqa: F401
import tool_attacks  # noqa: F401


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("bin")
    parser.add_argument("--only")
    parser.add_argument("--minutes", type=float, default=10.0)
    options = parser.parse_args()
    return ground.run(ground.Ground(options.bin), options.only, options.minutes * 60)


if __name__ == "__main__":
    sys.exit(main())
