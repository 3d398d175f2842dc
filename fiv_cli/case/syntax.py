"""What is wrong with a text that is no TOML, and how it is written instead.

The parser says where it stopped; what people write there is mostly one of a few things.
"""

from __future__ import annotations

import re

from fiv_cli.errors import Problem

_AT_LINE = re.compile(r" \(at (?:line (\d+), column (\d+)|end of document)\)$")
_ENDS = r"\s*(?=[,}\]#]|$)"
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"

# What stands in the line -> what to write; the first that is found is told.
_ADVICE = tuple(
    (re.compile(pattern), advice)
    for pattern, advice in (
        (
            r"^([^\s\"'=\[]*[^\x00-\x7F][^\s\"'=]*)\s*=",
            'a name in other letters stands in quotes: "{0}" = ...',
        ),
        (r"=\s*(?:None|null|nil|none|NULL)\b", "a key without a value is left out"),
        (r"[=\[,]\s*(True|False|yes|no|on|off)" + _ENDS, "write true or false"),
        (
            rf"[=\[,]\s*({_NUMBER})\s*:\s*({_NUMBER})",
            "a range: {{ start = {0}, stop = {1}, num = 9 }}",
        ),
        (rf"=\s*(\d+),(\d+){_ENDS}", "decimals stand behind a point: {0}.{1}"),
        (r"[=\[,]\s*([-+]?)\.(\d+)", "a digit stands before the point: {0}0.{1}"),
        (r"[=\[,]\s*([-+]?\d+)\.(?!\d)", "a digit stands behind the point: {0}.0"),
        (
            rf"[=\[,]\s*({_NUMBER})\s*([A-Za-z%°µ][^,}}\]\"'#=]*?){_ENDS}",
            'a number with its unit stands in quotes: "{0} {1}"',
        ),
        (r"=\s*\(([^)]*)\)", "a list stands in brackets: [{0}]"),
        (
            rf"^[\w.]+\s*=\s*({_NUMBER}\s*(?:,\s*{_NUMBER})+){_ENDS}",
            "a list stands in brackets: [{0}]",
        ),
        (r"^\s*([\w.]+)\s+([^=\s#]+)\s*(?:#.*)?$", "write {0} = {1}"),
        (r"=\s*([A-Za-z][^,}\]\"'#=]*?)" + _ENDS, 'a text stands in quotes: "{0}"'),
        (r"[\[,]\s*([A-Za-z][^,}\]\"'#=]*?)\s*[,\]]", 'a text stands in quotes: "{0}"'),
        (rf"({_NUMBER}|\"|'|\]|}})\s+(\w+)\s*=", "a comma stands before {1}"),
        (r"^\s*([\w.]+)\s*:\s*(.*\S)", "write {0} = {1}"),
        (r"\"[^\"]*\\", r"a backslash in double quotes is written \\; or use single quotes"),
        (r"[=,]\s*\{[^}]*$", "a table in braces ends in the same line, with }}"),
        (r"^\s*}", "a table in braces stands in one line; [NAME] begins one of several lines"),
        (r",\s*}", "no comma stands before the }}"),
        (r"^[^\"']*(?:\"[^\"]*|'[^']*)$", "quotes are closed in the same line"),
    )
)
# What the parser says of a text whose words are each in order -> what to write.
_OF_THE_WHOLE = {
    "Cannot overwrite": "each key once in its table",
    "Cannot declare": "each table once, its keys together; or [[NAME]] for each of several",
    "Unclosed array": "a list that begins above ends with ]",
    "Expected ']": "[NAME], or [[NAME]] for each of several",
}
_ALLOWED = (
    'KEY = a number, "a text", true, false, [a, list] or { a = "table" }; [TABLE]; # a comment'
)


def syntax_problem(message: str, text: str) -> Problem:
    """What the parser's `message` means in `text`, with the line and what to write there."""
    match = _AT_LINE.search(message)
    what = f"invalid TOML: {_AT_LINE.sub('', message)}"
    if match is None:
        return Problem("case", what, _ALLOWED)
    lines = text.splitlines() or [""]
    at_end = match[1] is None
    line = len(lines) if at_end else min(int(match[1]), len(lines))
    written = lines[line - 1].partition(" #")[0].strip()
    what += " at the end of the file" if at_end else f": {written}"
    column = None if at_end else int(match[2])
    return Problem("case", what, _ALLOWED, _advice(message, written), line, column)


def _advice(message: str, written: str) -> str:
    """What to write instead of a line; nothing where that is not known."""
    whole = next((said for start, said in _OF_THE_WHOLE.items() if message.startswith(start)), "")
    if whole:
        return whole
    found = ((pattern.search(written), advice) for pattern, advice in _ADVICE)
    return next((advice.format(*match.groups()) for match, advice in found if match), "")
