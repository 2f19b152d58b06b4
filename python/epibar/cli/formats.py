"""``epibar formats``: what can be exported, for which program, and what that loses."""

from __future__ import annotations

from argparse import Namespace

from ..export import FORMATS, Format
from .exit_codes import DONE
from .options import CommandParser, add_output_options
from .printer import Printer

__all__ = ["DESCRIPTION", "HELP", "NAME", "add_options", "run"]

NAME = "formats"
HELP = "what 'epibar export' writes: program, files, axes, units, and what each loses"
DESCRIPTION = (
    "List the formats of 'epibar export': the program, the files that are written, the unit of length, the "
    "axes, and what is lost. Verdicts, expected errors and clocks have a place in none of another program: "
    "network.json and calibration.json hold them."
)

TITLES = {
    "cameras": "Cameras in one world: epibar export DIR --format NAME --out PATH "
    "(--cameras where pairs have that name too)",
    "pairs": "Pairs of cameras: epibar export DIR --format NAME --out PATH",
    "tracks": "Walkers: epibar export DIR --format NAME --out PATH",
}
WIDTH = 100


def add_options(command: CommandParser) -> None:
    """Say what the command takes."""
    add_output_options(command, json="print it as JSON; for programs")


def run(args: Namespace) -> int:
    """Run the command."""
    printer = Printer(args.quiet, json=args.json, verbose=args.verbose)
    if args.json:
        import json

        entries = [_entry(holds, one) for holds, table in FORMATS.items() for one in table.values()]
        printer.json(json.dumps(entries, indent=1))
        return DONE
    for holds, table in FORMATS.items():
        printer.result(f"{TITLES[holds]}\n")
        for one in table.values():
            for line in _lines(one):
                printer.result(line)
        printer.result()
    printer.result(
        "None has a place for verdicts, expected errors and clocks: network.json and calibration.json do."
    )
    return DONE


def _entry(holds: str, one: Format) -> dict[str, object]:
    return {
        "format": one.name,
        "holds": holds,
        "program": one.program,
        "files": one.files,
        "unit": one.unit,
        "axes": one.axes,
        "loses": one.loses,
        "extra": one.extra or None,
        "read_by_epibar": one.reads,
    }


def _lines(one: Format) -> list[str]:
    import textwrap

    unit = "that of the network" if one.unit == "network" else one.unit
    rows = [one.program, f"writes {one.files}", f"unit: {unit}; {one.axes}", f"loses: {one.loses}"]
    rows += [f"needs: pip install 'epibar[{one.extra}]'"] if one.extra else []
    rows += ["epibar reads it, too, where it takes a camera file"] if one.reads else []
    first = " " * 14
    found = [textwrap.fill(row, WIDTH, initial_indent=first, subsequent_indent=first + "  ") for row in rows]
    return [f"  {one.name:<12}{found[0].strip()}", *found[1:]]
