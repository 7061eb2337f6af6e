# SPDX-License-Identifier: Apache-2.0
"""Manual pages and completion as the program writes them.

shell_files.py PROGRAM man|bash|zsh|fish     ends with 77, skipped, where the shell or man is not installed
"""
import glob
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

SKIPPED = 77
COMPLETES = [  # words, the last of which is completed; all that is offered
    (['quench', 'ru'], ['run']),
    (['quench', 'bricks', ''], ['merge', 'plan', 'run', 'status']),
    (['quench', '--v'], ['--version']),
    (['quench', 'run', '--fill-'], ['--fill-cavities', '--fill-holes']),
    (['quench', 'run', 'shape.off', '--fill', ''], ['auto', 'evenodd', 'nonzero', 'winding']),
    (['quench', 'run', '--threshold', 'o'], ['otsu']),
    (['quench', 'bricks', 'plan', '--siz'], ['--size']),
    (['quench', 'bricks', 'run', '--siz'], []),
    (['quench', 'sample', 'bu'], ['bumpy-sphere']),
    (['quench', 'core', 'shape.off', '-o', 'sh'], ['shape.off']),
    (['quench', 'run', 'with b'], ['with blank.ply']),
    (['quench', 'batch', 'scans', '--', ''], ['run', 'tree']),
]


def output_of(*command, **more):
    done = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          check=False, **more)
    return done.returncode, done.stdout, done.stderr


def commands_of(program, *before):
    """Every command of the program, as a tuple of words."""
    _, text, _ = output_of(program, *before, '--help')
    section = re.search(r'^Subcommands:\n((?:  .*\n)+)', text, re.M)
    for name in re.findall(r'^  (\S+)', section.group(1), re.M) if section else ():
        yield (*before, name)
        yield from commands_of(program, *before, name)


def check_manual(folder, program):
    if not shutil.which('man') or not shutil.which('groff'):
        return SKIPPED
    pages = glob.glob(os.path.join(folder, 'man1', '*.1'))
    commands = [(), *commands_of(program)]
    assert {os.path.basename(page) for page in pages} == {'-'.join(('quench', *c)) + '.1' for c in commands}, pages
    environment = {**os.environ, 'LC_ALL': 'C.UTF-8', 'MANWIDTH': '100', 'MAN_KEEP_FORMATTING': '', 'GROFF_NO_SGR': '1'}
    for command in commands:
        page = os.path.join(folder, 'man1', '-'.join(('quench', *command)) + '.1')
        assert output_of('groff', '-man', '-ww', '-Tutf8', '-z', page) == (0, '', ''), page
        code, text, said = output_of('man', '--warnings', '--no-hyphenation', '--no-justification', '-P', 'cat', '-l', page,
                                     env=environment)
        assert code == 0 and not said, said
        text = re.sub('.\b', '', text)
        for section in ('NAME', 'SYNOPSIS', 'DESCRIPTION', 'OPTIONS', 'EXIT STATUS', 'EXAMPLES', 'SEE ALSO'):
            assert f'\n{section}\n' in text, f'{page} has no {section}'
        helped = output_of(program, *command, '--help')[1]
        for option in re.findall(r'^  (?:-\w,)?(--[a-z0-9-]+)', helped, re.M):
            assert re.search(rf'^       (-\w, )?(--\S+, )*{option}\b', text, re.M), f'{page} has no {option}'
        words = re.sub(r'\s+', ' ', text)
        for sentence in re.findall(r'^(?=  [- ]).{28}  (\S.*)$', helped, re.M):
            assert sentence.strip() in words, f'{page} does not say: {sentence}'
    return 0


def bash_offers(folder, lines):
    """What bash offers for each of the lines, lists of words the last of which is completed."""
    script = 'source "$1"\n' + ''.join(
        f'COMP_WORDS=({" ".join(map(shlex.quote, words))}); COMP_CWORD={len(words) - 1}; _quench; '
        'printf "%s\\n" "${COMPREPLY[@]}" =====\n' for words in lines)
    code, text, said = output_of('bash', '--norc', '-c', script, 'bash', os.path.join(folder, 'bash', 'quench'))
    assert code == 0 and not said, said
    return [[line for line in part.split('\n') if line] for part in text.split('=====\n')[:-1]]


def check_bash(folder, program):
    if not shutil.which('bash'):
        return SKIPPED
    cases = COMPLETES + [
        (['quench', 'run', '--fill', '=', 'e'], ['evenodd']),  # as bash divides them
        (['quench', 'run', '--fill', '='], ['auto', 'evenodd', 'nonzero', 'winding']),
        (['quench', 'run', '--fill=e'], ['--fill=evenodd']),
        (['quench', 'batch', 'scans', '--', 'tree', '--kind', 'n'], ['neuron']),
        (['quench', 'run', '-o', ''], ['folder'])]
    for (words, offered), found in zip(cases, bash_offers(folder, [words for words, _ in cases])):
        assert sorted(found) == offered, (words, found)
    options = [['quench', *command, option] for command in commands_of(program)
               for option in re.findall(r'^  (?:-\w,)?(--[a-z0-9-]+)', output_of(program, *command, '--help')[1], re.M)]
    for words, found in zip(options, bash_offers(folder, options)):
        assert words[-1] in found, (words, found)
    return 0


def check_zsh(folder, _):
    if not shutil.which('zsh'):
        return SKIPPED
    code, _, said = output_of('zsh', '-n', os.path.join(folder, 'zsh', '_quench'))
    assert code == 0 and not said, said
    return 0


def check_fish(folder, program):
    if not shutil.which('fish'):
        return SKIPPED
    file = os.path.join(folder, 'fish', 'quench.fish')
    code, _, said = output_of('fish', '-n', file)
    assert code == 0 and not said, said
    path = os.path.dirname(program) + os.pathsep + os.environ['PATH']
    for words, offered in COMPLETES:
        line = ' '.join(word.replace(' ', '\\ ') for word in words)
        code, text, said = output_of('fish', '--no-config', '-c', 'source $argv[1]; complete -C $argv[2]', file, line,
                                     env={**os.environ, 'PATH': path, 'HOME': os.getcwd()})
        assert code == 0 and not said, said
        found = {one.split('\t')[0] for one in text.splitlines()}
        assert found == set(offered), (words, found)
    return 0


def main():
    program = os.path.abspath(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        code, text, said = output_of(program, 'shell-files', os.path.join(folder, 'shell'))
        assert (code, text, said) == (0, '', ''), said
        os.makedirs(os.path.join(folder, 'work', 'folder'))
        os.chdir(os.path.join(folder, 'work'))
        for name in ('shape.off', 'with blank.ply'):
            with open(name, 'w', encoding='utf-8'):
                pass
        check = {'man': check_manual, 'bash': check_bash, 'zsh': check_zsh, 'fish': check_fish}[sys.argv[2]]
        result = check(os.path.join(folder, 'shell'), program)
        os.chdir('/')
        return result


if __name__ == '__main__':
    sys.exit(main())
