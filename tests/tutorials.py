# SPDX-License-Identifier: Apache-2.0
"""Runs the tutorials of docs/tutorials as a reader would, and checks that what they say is what comes out.

tutorials.py NAME --program QUENCH [--build FOLDER] [--write] [--keep FOLDER]

From top to bottom, in an empty folder:

- a block of sh is run by a shell that ends at the first command that fails; one of python in an interpreter that lives as
  long as the tutorial; any other block behind a paragraph that ends in "`NAME`:" is the file of that name;
- a block of text behind them is what they print. `...` stands for lines that are left out. Times are not compared, and the
  last digit of a fraction may be off by one;
- a table behind a paragraph that names a `.csv` file holds rows of it, found by their first cell, or, where its first column
  is called "column", columns of its only row. Numbers are those of the file, rounded;
- where the text says `make install PREFIX=FOLDER`, what it installs is put there from the build folder; $HOME is a folder
  of the test's own, and the tutorial is followed in another one, not in the sources;
- a picture is that of the file named in the line behind it, `*`FILE`*`, at half its size;
- numbers in digits in the text around occur in the commands, in what they print, or in a table; fractions may be rounded.

--write puts what comes out into blocks of text, tables and pictures. Ends with 77, skipped, where Pillow, numpy or a compiler is
missing."""
import argparse
import contextlib
import csv
import io
import os
import re
import shutil
import subprocess
import sys
import tempfile
import traceback

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..')
SKIPPED = 77
NUMBER = r'-?\d+(?:\.\d+)?(?:e-?\d+)?'


class Wrong(Exception):
    """What a tutorial says and what came out differ."""


def elements(text):
    """Blocks, tables, pictures and paragraphs in order, each as (kind, text, first line, last line); lines from 0."""
    lines, found, i = text.split('\n'), [], 0
    while i < len(lines):
        start = i
        if lines[i].startswith('```'):
            i = next(j for j in range(i + 1, len(lines)) if lines[j].startswith('```'))
            found.append((lines[start][3:].strip() or 'shown', '\n'.join(lines[start + 1 : i]), start + 1, i))
            i += 1
        elif lines[i].startswith('|'):
            while i < len(lines) and lines[i].startswith('|'):
                i += 1
            found.append(('table', '\n'.join(lines[start:i]), start, i))
        elif lines[i].startswith('!['):
            i += 1
            while i < len(lines) and not lines[i].strip():
                i += 1
            found.append(('picture', '\n'.join(lines[start : i + 1]), start, i + 1))
            i += 1
        elif lines[i].strip():
            while i < len(lines) and lines[i].strip() and not re.match(r'```|\||!\[', lines[i]):
                i += 1
            found.append(('prose', '\n'.join(lines[start:i]), start, i))
        else:
            i += 1
    return found


def without_progress(printed):
    """Lines of progress come only where something takes long."""
    return [
        line.rstrip()
        for line in printed.split('\n')
        if not re.fullmatch(r'[a-z ]+: (\d+%.*|done in .*)', line.rstrip())
    ]


def same_line(said, printed):
    """Equal but for times and one in the last digit of a fraction."""
    plain = [re.sub(r'\b\d+\.\d s\b', 'TIME', line) for line in (said.rstrip(), printed)]
    if re.sub(NUMBER, '#', plain[0]) != re.sub(NUMBER, '#', plain[1]):
        return False
    for a, b in zip(re.findall(NUMBER, plain[0]), re.findall(NUMBER, plain[1])):
        if a == b:
            continue
        digits = len(a.split('.')[1]) if '.' in a and 'e' not in a else 0
        if not digits or abs(float(a) - float(b)) > 1.01 * 10**-digits:
            return False
    return True


def check_printed(said, printed):
    """Each line of the block in the order in which it was printed; none is left out but where `...` says so."""
    lines, at, gap = [line for line in printed if line], 0, False
    for line in [line for line in said.split('\n') if line.strip()]:
        if line.strip() == '...':
            gap = True
            continue
        found = next((k for k in range(at, len(lines)) if same_line(line, lines[k])), None)
        if found is None or (found > at and not gap):
            raise Wrong(f'it says\n  {line}\nand printed was\n  ' + '\n  '.join(lines[at:]))
        at, gap = found + 1, False
    if at < len(lines) and not gap:
        raise Wrong('more was printed than it says:\n  ' + '\n  '.join(lines[at:]))


def rewritten(said, printed):
    """What was printed, without what the block leaves out: lines stay that begin as one of it does up to its first digit."""
    lines, kept, at = [line for line in printed if line], [], 0
    old = [line for line in said.split('\n') if line.strip()]
    if not old or '...' not in [line.strip() for line in old]:
        return '\n'.join(lines)
    for line in old:
        if line.strip() == '...':
            kept.append(line)
            continue
        start = re.match(r'\D*', line)[0] or line.split()[0] + ' '
        found = next((k for k in range(at, len(lines)) if lines[k].startswith(start)), None)
        if found is not None:
            kept.append(lines[found])
            at = found + 1
    return '\n'.join(kept)


def rounded(text, digits):
    """Whether a number of a file, rounded as `text` is, gives it."""
    try:
        shown, value = float(text), float(digits)
    except ValueError:
        return False
    places = len(text.split('.')[1]) if '.' in text else 0
    return abs(shown - value) <= 0.5001 * 10**-places


def check_table(table, file, write):
    """The table against the rows of a CSV file; the table as it should be."""
    head, line, *rows = [[cell.strip() for cell in line.strip('|').split('|')] for line in table.split('\n')]
    with open(file, newline='', encoding='utf-8') as opened:
        there = [{name.split(' [')[0]: value for name, value in row.items()} for row in csv.DictReader(opened)]
    for row in rows:
        if head[0] == 'column':
            cells = {1: there[0].get(row[0])}
        else:
            match = next((r for r in there if r.get(head[0]) == row[0]), {})
            cells = {k: match.get(name) for k, name in enumerate(head)}
        for k, value in cells.items():
            if value is None or (row[k] != value and not rounded(row[k], value)):
                if not write or not value:
                    raise Wrong(f'{file}: {head[k]} of {row[0]} is {value}, not {row[k]}')
                row[k] = (
                    value
                    if not re.fullmatch(NUMBER, value)
                    else f'{float(value):{".0f" if abs(float(value)) >= 1000 else ".4g"}}'
                )
    if not rows:
        raise Wrong(f'the table of {file} is empty')
    lines = ['| ' + ' | '.join(row) + ' |' for row in (head, *rows)]
    return '\n'.join([lines[0], '|' + '|'.join(line) + '|', *lines[1:]]).replace('  |', ' |')


def halved(file):
    """The picture at half its size, on white, as an array of rows, columns and three colours."""
    import numpy
    from PIL import Image

    image = Image.open(file).convert('RGBA')
    ground = Image.new('RGBA', image.size, 'white')
    image = Image.alpha_composite(ground, image).convert('RGB')
    return numpy.asarray(image.resize((image.width // 2, image.height // 2), Image.BOX), float)


def check_picture(file, shown, write):
    """That the picture of a tutorial is the file, at half its size."""
    import numpy
    from PIL import Image

    made = halved(file)
    if write:
        os.makedirs(os.path.dirname(shown), exist_ok=True)
        Image.fromarray(made.round().astype('uint8')).save(shown, optimize=True)
    there = numpy.asarray(Image.open(shown).convert('RGB'), float)
    if there.shape != made.shape:
        raise Wrong(
            f'{os.path.basename(shown)} is {there.shape[1]} x {there.shape[0]}, half of {file} {made.shape[1]} x {made.shape[0]}'
        )
    off = numpy.abs(there - made).mean(axis=2)
    rows, columns = (n // 20 * 20 for n in off.shape)
    tiles = off[:rows, :columns].reshape(rows // 20, 20, columns // 20, 20).mean(axis=(1, 3))
    if off.mean() > 1 or tiles.max() > 12:
        raise Wrong(
            f'{os.path.basename(shown)} is not {file}: {off.mean():.2f} of 255 off on average, {tiles.max():.1f} in a tile of 20 x 20'
        )


class Reader:
    """One who follows a tutorial."""

    def __init__(self, options):
        self.options, self.evidence, self.printed, self.csv, self.pending = options, [], None, None, None
        self.names = {'__name__': 'tutorial'}
        self.environment = dict(
            os.environ, PATH=os.path.join(os.getcwd(), '.bin') + os.pathsep + os.environ['PATH'], LC_ALL='C.UTF-8'
        )
        os.mkdir('.bin')
        os.symlink(os.path.abspath(options.program), '.bin/quench')

    def shell(self, code):
        done = subprocess.run(
            ['sh', '-eu', '-c', code], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=self.environment
        )
        self.printed = without_progress(done.stdout)
        if done.returncode:
            raise Wrong(f'code {done.returncode} of\n{code}\n' + '\n'.join(self.printed))

    def python(self, code):
        if self.options.build:
            sys.path.insert(0, os.path.join(self.options.build, 'python'))
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(code, 'tutorial', 'exec'), self.names)
        self.printed = without_progress(printed.getvalue())

    def follow(self, kind, text):
        """Does what an element says; the text that should be there instead, or None."""
        if kind in ('sh', 'python') and not self.pending:
            self.evidence.append(text)
            self.shell(text) if kind == 'sh' else self.python(text)
            self.evidence += self.printed
        elif kind == 'text':
            if self.printed is None:
                raise Wrong('a block of text behind nothing that prints')
            if self.options.write:
                return rewritten(text, self.printed)
            check_printed(text, self.printed)
            self.printed = None
        elif kind == 'table' and self.csv:
            table = check_table(text, self.csv, self.options.write)
            self.evidence.append(table)
            return table if table.split('\n')[2:] != text.split('\n')[2:] and self.options.write else None
        elif kind == 'picture':
            shown, file = re.fullmatch(r'!\[[^\]]*\]\(([^)]*)\)\s*\*`([^`]*)`.*\*', text, re.S).groups()
            check_picture(file, os.path.normpath(os.path.join(ROOT, 'docs', 'tutorials', shown)), self.options.write)
        elif self.pending:
            with open(self.pending, 'w', encoding='utf-8') as file:
                file.write(text + '\n')
            self.evidence.append(text)
        names = re.findall(r'`([\w./-]+)`', text) if kind == 'prose' else []
        self.csv = next((name for name in reversed(names) if name.endswith('.csv') and os.path.exists(name)), None)
        self.pending = names[-1] if kind == 'prose' and re.search(r'`[\w./-]+`:$', text) and not self.csv else None
        return None

    def check_numbers(self, prose):
        """Every number in digits in the text was in a command, in a table, or printed."""
        known = set(re.findall(NUMBER, '\n'.join(self.evidence)))
        known |= {f'{float(number):.{digits}f}' for number in known if '.' in number for digits in range(1, 5)}
        for text in prose:
            text = re.sub(r'`[^`]*`|\]\([^)]*\)|^#+ |^\d+\. |\b[23]D\b|C\+\+\d+', ' ', text, flags=re.M)
            unknown = [number for number in re.findall(r'(?<![\w.])\d+(?:\.\d+)?(?![\w])', text) if number not in known]
            if unknown:
                raise Wrong(f'{", ".join(unknown)} was in no command, no output and no table:\n{text.strip()}')


def install(found, build, home):
    """Does what `make install PREFIX=...` in the text does, with `home` as $HOME; the new folder to follow the rest in."""
    os.environ['HOME'] = home
    said = re.search(r'`make install PREFIX=([^`]+)`', '\n'.join(text for kind, text, *_ in found if kind == 'prose'))
    prefix = os.path.expandvars(said.group(1)) if said else ''
    if not prefix.startswith(home + os.sep):  # a relative one would be in the sources
        raise Wrong('nothing says `make install PREFIX=$HOME/...`')
    command = ['cmake', '--install', build, '--component', 'development', '--prefix', prefix]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    new = os.path.join(home, 'new')
    os.mkdir(new)
    return new


def missing(name, build):
    """What the tutorial needs and this machine has not."""
    import importlib.util

    lacking = [module for module in ('numpy', 'PIL') if importlib.util.find_spec(module) is None]
    if name == 'python' and not (build and os.path.isdir(os.path.join(build, 'python', 'quench'))):
        lacking.append('the module of Python')
    if name == 'cpp':
        lacking += [tool for tool in ('cmake', 'c++', 'pkg-config') if not shutil.which(tool)]
        if not build:
            lacking.append('the library')
    return lacking


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('name')
    parser.add_argument('--program', required=True)
    parser.add_argument('--build', help='the build folder: its module of Python, its library for C++')
    parser.add_argument('--write', action='store_true')
    parser.add_argument('--keep', help='work in this folder, and leave it')
    options = parser.parse_args()
    options.build = options.build and os.path.abspath(options.build)
    options.program = os.path.abspath(options.program)
    if lacking := missing(options.name, options.build):
        print(f'skipped: there is no {", ".join(lacking)}')
        sys.exit(SKIPPED)
    page = os.path.join(ROOT, 'docs', 'tutorials', f'{options.name}.md')
    with open(page, encoding='utf-8') as file:
        lines = file.read().split('\n')
    work = folder = os.path.abspath(options.keep or tempfile.mkdtemp(prefix='quench-tutorial-'))
    os.makedirs(work, exist_ok=True)
    try:
        found = elements('\n'.join(lines))
        if not any(kind in ('sh', 'python') for kind, *_ in found):
            raise Wrong('nothing is run')
        if options.name == 'cpp':
            work = install(found, options.build, work)
        os.chdir(work)
        reader = Reader(options)
        changed = [(reader.follow(kind, text), first, last) for kind, text, first, last in found]
        for text, first, last in reversed(changed):
            if text is not None:
                lines[first:last] = text.split('\n')
        if options.write:
            with open(page, 'w', encoding='utf-8') as file:
                file.write('\n'.join(lines))
        reader.check_numbers([text for kind, text, *_ in found if kind == 'prose'])
        print(
            f'{options.name}: {sum(kind in ("sh", "python") for kind, *_ in found)} blocks run, '
            f'{sum(kind in ("text", "table", "picture") for kind, *_ in found)} results compared'
        )
    except Wrong as wrong:
        sys.exit(f'docs/tutorials/{options.name}.md: {wrong}')
    except Exception:
        traceback.print_exc()
        sys.exit(f'docs/tutorials/{options.name}.md: what it says does not work')
    finally:
        os.chdir(ROOT)
        if not options.keep:
            shutil.rmtree(folder, ignore_errors=True)


if __name__ == '__main__':
    main()
