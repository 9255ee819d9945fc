"""`python -m peers [--quick] [--tets N] [--repeats N] [--only CASE]`: runs all and writes results."""

import argparse
import json
import subprocess
import time
from datetime import UTC, datetime

from . import cases, factor, pairs, report
from .engines import BINARIES, HERE, WORK
from .hand import Hand


def main():
    options = parse()
    start = time.time()
    machine = report.machine(HERE)
    WORK.mkdir(exist_ok=True)
    file = WORK / f"hand-{options.tets}.json"
    subprocess.run([BINARIES / "export", str(options.tets), str(file)], check=True)
    hand = Hand(file)
    if options.quick:
        cases.REFERENCE_STEP = report.REFERENCE_STEP = 1e-3
    steps = (5e-3,) if options.quick else cases.STEPS
    repeats = 1 if options.quick else options.repeats

    found = {"cases": {}, "references": {}}
    say(start, "cantilever")
    found["bar"] = cases.bar(repeats)
    for case in cases.CASES:
        if options.only and case.name != options.only:
            continue
        say(start, f"{case.name}: reference")
        settled, notes = cases.reference(case, hand)
        found["references"][case.name] = notes
        rows = []
        for step in steps:
            say(start, f"{case.name}: {step * 1e3:.3g} ms")
            rows += cases.run(case, hand, step, repeats, settled)
        found["cases"][case.name] = rows
    say(start, "stability")
    found["stability"] = cases.stability(hand, 0.1 if options.quick else 0.3)

    found.update(
        date=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        machine=machine,
        repeats=repeats,
        hand={
            "tets": len(hand.tets),
            "nodes": len(hand.nodes),
            "ties": len(hand.ties),
            "mass": hand.mass(),
        },
        took=time.time() - start,
    )
    preface = (HERE / "peers" / "preface.md").read_text(encoding="utf-8")
    say(start, "pairs of rigid shapes")
    text = report.markdown(found, preface) + "\n" + pairs.section()
    say(start, "factor of the flesh")
    text += "\n" + factor.section()
    print(text)
    # A quick or partial run proves that all works; it does not replace the record.
    folder = WORK if options.quick or options.only else HERE
    (folder / "results.md").write_text(text, encoding="utf-8")
    (folder / "results.json").write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    say(start, f"written to {folder / 'results.md'}")


def parse():
    parser = argparse.ArgumentParser(prog="bench/peers/run", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="one step size, one repeat")
    parser.add_argument("--tets", type=int, default=600, help="wanted number of tetrahedra")
    parser.add_argument("--repeats", type=int, default=2, help="repeats of each timed run")
    parser.add_argument("--only", choices=[case.name for case in cases.CASES], help="one case")
    return parser.parse_args()


def say(start, what):
    print(f"[{time.time() - start:5.0f} s] {what}", flush=True)


if __name__ == "__main__":
    main()
