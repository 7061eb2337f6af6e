# SPDX-License-Identifier: Apache-2.0
"""The library knows no command line: no string in src/ or include/ spells an option ("--spacing"). Its errors name a field,
for which the program and the Python module have their own words.

option_names.py [ROOT]     prints every line that does; ends with 1 when there is one
"""
import os
import re
import sys

OPTION = re.compile(r'(?<![\w<!-])--[a-z]')  # not "<!--comment", not "a--b"
STRING_OR_COMMENT = re.compile(r'"(?:[^"\\\n]|\\.)*"|//[^\n]*')


def spelled(text):
    """Numbers and texts of the lines with an option in a string."""
    for number, line in enumerate(text.split('\n'), 1):
        if any(part.startswith('"') and OPTION.search(part) for part in STRING_OR_COMMENT.findall(line)):
            yield number, line.strip()


def main():
    root = sys.argv[1] if len(sys.argv) > 1 else os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    # The check itself: what it finds and what it lets pass.
    assert [n for n, _ in spelled('x\n fail("give --spacing");\n --depth; "<!--data-->"; // "--not"\n')] == [2]
    found, files = [], 0
    for top in ('src', 'include'):
        for folder, _, names in os.walk(os.path.join(root, top)):
            for name in names:
                files += 1
                path = os.path.join(folder, name)
                with open(path, encoding='utf-8') as file:
                    found += [f'{os.path.relpath(path, root)}:{n}: {line}' for n, line in spelled(file.read())]
    print('\n'.join(found) or f'{files} files without the name of an option')
    return 1 if found or not files else 0


if __name__ == '__main__':
    sys.exit(main())
