#!/usr/bin/env python3
"""ENSONIFY=PROGRAM commands_test.py [--write] [--keep] PAGE...

Does what a reader of a page does: every fenced block is run in order, in a fresh folder that looks
like the repository's root, with the program under test as `ensonify` and as build/release/ensonify.
PAGE is relative to the repository, docs/export.md. --write renews the outputs shown in the page, which
then are no failures; --keep leaves the folder there.

  ```sh        run by bash (-e, -o pipefail); variables and folder last to the page's end
  ```console   `$ COMMAND` and what it prints, compared where anything is shown
  ```python    executed, all blocks of a page in one process
  ```yaml      a scenario: `ensonify check`; a sweep: `ensonify sweep --list`; a part of a scenario:
               laid beside a small sonar, then `ensonify check`; with 16 beams but for a file=
  ```json      parsed      ```csv   rows of one width      ```text and others: shown

In what is shown `…` stands for any text, alone on a line for any lines. The folder's own path is
shown as /home/me/ensonify.

What cannot be taken literally has a directive on a line of its own above the block,
`<!-- docs-test: KEY=VALUE; KEY -->`:

  skip=REASON      not run; the reason is printed
  needs=NAME,NAME  not run where a program or Python module is not installed
  minutes          not run by tests that are to be short
  file=NAME        the block is the content of this file, for the blocks below it
  output           the block is what the sh or Python block before it printed
  varies           numbers with a unit of time, size or speed may differ; varies=numbers: all may
  fails=STATUS     the command, or the check of the scenario, ends with this exit status
  base=FILE        of a part of a scenario: laid beside this file, not beside a preset

`<!-- docs-test: small -->` holds for the whole page, which shows no number that depends on it: the scenes
of scenes/ have 64 beams there and small Cartesian images. With ENSONIFY_DOCS_WITHOUT=NAME,NAME these
programs and Python modules count as not installed, and with `minutes` among them such blocks are left out.
"""

import os
import sys
from pathlib import Path

from pages import ROOT, BadPage, parse
from run_blocks import Outcome, needs_a_place, run_block
from workplace import Workplace


def run_page(name, program, root=ROOT, keep=False):
    """(page, outcome) of the page."""
    page, outcome = parse(name, root), Outcome()
    # Most pages have no commands, and a folder takes longer to make than they to read.
    place = Workplace(program, root, page.small) if any(map(needs_a_place, page.blocks)) else None
    try:
        for block in page.blocks:
            run_block(place, block, outcome, page.name)
    finally:
        if place:
            place.close(keep)
    if keep and place:
        print(f"{name}: {place.root}")
    return page, outcome


def write(page, outcome):
    lines = list(page.lines)
    for block, text in sorted(outcome.renewed, key=lambda item: -item[0].first):
        lines[block.first:block.last] = [(block.indent + line).rstrip() for line in text.split("\n")[:-1]]
    page.path.write_text("\n".join(lines), encoding="utf-8")
    print(f"{page.name}: {len(outcome.renewed)} blocks written anew")


def has_failed(outcome, written):
    return len(outcome.failures) > (outcome.differences if written else 0)


def report(name, outcome):
    for line, reason in outcome.skips:
        print(f"{name}:{line}: skipped: {reason}")
    for line, text in outcome.failures:
        print(f"{name}:{line}: FAILED: {text}\n")
    done = ", ".join(f"{number} {what}" for what, number in outcome.counts.items())
    print(f"{name}: {done or 'nothing to run'}; {len(outcome.skips)} skipped, "
          f"{len(outcome.failures)} failed")


def main(arguments):
    options = {word for word in arguments if word.startswith("--")}
    names = [word for word in arguments if not word.startswith("--")]
    program = os.environ.get("ENSONIFY", "")
    if options - {"--write", "--keep"} or not names or not Path(program).is_file():
        print(__doc__.split("\n\n")[0], file=sys.stderr)
        return 2
    failed = False
    for name in names:
        try:
            page, outcome = run_page(name, str(Path(program).resolve()), keep="--keep" in options)
        except BadPage as error:
            print(f"FAILED: {error}")
            failed = True
            continue
        report(name, outcome)
        if "--write" in options and outcome.renewed:
            write(page, outcome)
        failed = failed or has_failed(outcome, "--write" in options)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
