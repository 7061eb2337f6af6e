# SPDX-License-Identifier: Apache-2.0
"""The macros in ImageJ, without windows: what they open and draw is what the program computes."""
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
PROGRAM = os.environ.get('QUENCH') or shutil.which('quench')
JARS = ['/usr/share/java/ij.jar', os.environ.get('IMAGEJ_JAR', '')]


def write_tiff(file, stack):
    """Pages of 8 bits, uncompressed, with the description ImageJ writes: spacing 0.5 x 0.5 x 2 mm."""
    pages, rows, columns = stack.shape
    text = f'ImageJ=1.53t\nimages={pages}\nslices={pages}\nunit=mm\nspacing=2.0\n'.encode() + b'\0'
    note = 8 + stack.size  # ImageJ wants the pages behind one another
    ratio = note + len(text) + len(text) % 2
    data, at = stack.tobytes() + text + b'\0' * (len(text) % 2) + struct.pack('<II', 2, 1), ratio + 8
    first = at
    for page in range(pages):
        tags = [
            (256, 4, 1, columns),
            (257, 4, 1, rows),
            (258, 3, 1, 8),
            (259, 3, 1, 1),
            (262, 3, 1, 1),
            (270, 2, len(text), note),
            (273, 4, 1, 8 + page * rows * columns),
            (277, 3, 1, 1),
            (278, 4, 1, rows),
            (279, 4, 1, rows * columns),
            (282, 5, 1, ratio),
            (283, 5, 1, ratio),
        ]
        at += 2 + 12 * len(tags) + 4
        data += struct.pack('<H', len(tags)) + b''.join(struct.pack('<HHII', *tag) for tag in tags)
        data += struct.pack('<I', at if page + 1 < pages else 0)
    with open(file, 'wb') as opened:
        opened.write(struct.pack('<2sHI', b'II', 42, first) + data)


def macro(jar, name, argument, folder):
    """Runs a macro; what it printed."""
    done = subprocess.run(
        ['java', '-jar', jar, '-batch', name, argument], cwd=folder, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0 and 'Macro Error' not in done.stdout, done.stdout + done.stderr
    return done.stdout


def values(file):
    """What the program reads from an image, as an array with x first."""
    import quench

    return np.asarray(quench.read(file).array)


def spacing(file):
    import quench

    return quench.read(file).spacing


def check_thresholds(jar, folder):
    """Thresholds of ImageJ, of images with calibrated values (signed CT), with and without an upper end."""
    signed = (  # 20 and 200 become -820 and 800
        'run("16-bit"); run("Macro...", "code=v=31768+v*9");'
        ' run("Calibrate...", "function=[Straight Line] unit=HU text1=[0 65535] text2=[-32768 32767]");'
    )
    stack = signed.replace('v*9"', 'v*9 stack"')  # 10 and 150: -910 and 350
    bright, dark = 'bright', 'dark'
    for name, before, lower, upper, taken, message in (
        ('bytes', '', 100, 255, bright, False),
        ('band', '', 100, 210, bright, False),
        ('above', '', 100, 150, bright, True),
        ('low', '', 0, 100, dark, False),
        ('ct', signed, -100, 32767, bright, False),
        ('ct_low', signed, -32768, -100, dark, False),
        ('ct_above', signed, -300, 200, bright, True),
        ('ct_minus', signed, -1, 32767, bright, False),
        ('ct_stack', stack, -100, 32767, bright, False),
        ('ct_stack_low', stack, -32768, -100, dark, False),
        ('float', 'run("32-bit"); run("Subtract...", "value=100.25");', -20.5, 1e30, bright, False),
        ('float_low', 'run("32-bit"); run("Subtract...", "value=100.25");', -1e30, -20.5, dark, False),
    ):
        source = 'stack' if 'stack' in name else 'image'
        for kind in ('Thickness', 'Skeleton'):
            with open(f'{folder}/set.ijm', 'w', encoding='utf-8') as file:
                file.write(
                    f'open("{folder}/{source}.tif"); {before}\nsetThreshold({lower}, {upper});\n'
                    f'runMacro("{HERE}/Quench_{kind}.ijm", "quench={PROGRAM} save={folder}/{name}_{kind}.tif");'
                )
            said = macro(jar, f'{folder}/set.ijm', '', folder)
            assert ('upper end' in said) == message, f'{name}, {kind}: {said}'
        bar = values(f'{folder}/{source}.tif') > 100
        found = values(f'{folder}/{name}_Thickness.tif') > 0
        assert np.array_equal(found, bar if taken == bright else ~bar), f'{name}: {found.mean()} of the image'
    print('thresholds: of signed and calibrated values, dark things, upper ends')


def main():
    jar = next((jar for jar in JARS if jar and os.path.exists(jar)), None)
    if not jar or not shutil.which('java'):
        print('there is no ImageJ (Debian: imagej)')
        sys.exit(77)
    if not os.environ.get('DISPLAY'):
        print('there is no display for ImageJ; run it under xvfb-run')
        sys.exit(77)
    folder = tempfile.mkdtemp(prefix='quench-fiji-')
    try:
        row, column = np.indices((80, 120))
        image = np.where(
            (abs(row - 40) < 11) & (abs(column - 60) < 50) | (np.hypot(row - 40, column - 60) < 25), 200, 20
        ).astype(np.uint8)
        stack = np.where(
            np.hypot(*(np.indices((12, 40, 60))[1:] - np.array([20, 30]).reshape(2, 1, 1, 1))) < 12, 150, 10
        ).astype(np.uint8)
        write_tiff(f'{folder}/image.tif', image[None])
        write_tiff(f'{folder}/stack.tif', stack)
        for name, threshold, drawn in (('image', 100, 1), ('stack', 100, 1)):
            said = macro(
                jar,
                f'{HERE}/Quench_Thickness.ijm',
                f'open={folder}/{name}.tif threshold={threshold} quench={PROGRAM} save={folder}/{name}_map.tif',
                folder,
            )
            subprocess.run(
                [
                    PROGRAM,
                    'thickness',
                    f'{name}.tif',
                    '--threshold',
                    str(threshold),
                    '-o',
                    f'{name}_program.tif',
                    '--quiet',
                ],
                check=True,
                cwd=folder,
            )
            ours, theirs = values(f'{folder}/{name}_map.tif'), values(f'{folder}/{name}_program.tif')
            assert ours.shape == theirs.shape and np.array_equal(
                ours, theirs
            ), f'{name}: the map is not that of the program'
            assert 'thickness.tif' in said and ours.max() > 10
            assert np.allclose(spacing(f'{folder}/{name}_map.tif'), spacing(f'{folder}/{name}.tif'))
            said = macro(
                jar,
                f'{HERE}/Quench_Skeleton.ijm',
                f'open={folder}/{name}.tif threshold={threshold} quench={PROGRAM} '
                f'save={folder}/{name}_lines.tif table={folder}/{name}.csv',
                folder,
            )
            lines = int(re.search(r'(\d+) lines drawn', said)[1])
            with open(f'{folder}/count.ijm', 'w', encoding='utf-8') as file:
                file.write(
                    'open(getArgument());\nOverlay.activateSelection(0); getSelectionBounds(x, y, w, h);\n'
                    'print("overlay " + Overlay.size + " " + x + " " + y);'
                )
            size, x, y = re.search(
                r'overlay (\d+) (\S+) (\S+)', macro(jar, f'{folder}/count.ijm', f'{folder}/{name}_lines.tif', folder)
            ).groups()
            assert int(size) == lines > 3, f'{size} lines in the overlay, {lines} drawn'
            with open(f'{folder}/{name}.csv', encoding='utf-8') as file:
                assert file.readline().startswith('branch,') and len(file.readlines()) >= drawn
            if name == 'image':  # along the middle of the bar, which is row 40, 40.5 in ImageJ
                assert abs(float(y) - 40.5) < 8 and 5 <= float(x) <= 115, (x, y)
            print(f'{name}: thickness as the program has it, up to {ours.max():.2f}; {lines} lines in the overlay')
        check_thresholds(jar, folder)
        said = macro(
            jar, f'{HERE}/Quench_Thickness.ijm', f'open={folder}/image.tif threshold=900 quench={PROGRAM}', folder
        )
        assert 'Quench: ' in said and 'quench' in said, said
        said = macro(
            jar, f'{HERE}/Quench_Thickness.ijm', f'open={folder}/image.tif threshold=100 quench=/nowhere/quench', folder
        )
        assert 'Quench: ' in said and '/nowhere/quench' in said, said
        print('an empty shape and a program that is not there: said, and no window')
    finally:
        shutil.rmtree(folder)


if __name__ == '__main__':
    main()
