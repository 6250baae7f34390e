"""What is wrong with a scenario."""
from __future__ import annotations

import re
from dataclasses import dataclass
from typing import List, Optional

_FAULT = re.compile(r"^(?:(?P<file>[^\n]*?):(?P<line>\d+):(?P<column>\d+): |(?P<option>--set [\w.-]+): )?"
                    r"(?:(?P<key>[A-Za-z_][\w.-]*): )?(?P<advice>.*)$")


@dataclass(frozen=True)
class Fault:
    """One fault: where it is (None where it has no such place), and what is wrong and accepted.

    `file` is `--set KEY` where the value comes from `set`.
    """

    file: Optional[str]
    line: Optional[int]
    column: Optional[int]
    key: Optional[str]
    advice: str


class ScenarioError(ValueError):
    """A scenario that cannot be read or whose world cannot be built. Its text has a line for each fault."""

    @property
    def faults(self) -> List[Fault]:
        """All of them, in the order of the text."""
        faults = []
        for line in str(self).splitlines():
            match = _FAULT.match(line)
            assert match is not None  # the pattern takes every line
            has_place = match["line"] is not None
            faults.append(Fault(match["file"] or match["option"], int(match["line"]) if has_place else None,
                                int(match["column"]) if has_place else None, match["key"], match["advice"]))
        return faults
