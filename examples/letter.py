#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The strokes of a letter, for a plotter or an engraver, by the program `quench` from SVG to SVG.

usage: letter.py [-o FOLDER]

Draws the outline of an R (letter.svg), writes its skeleton into the folder `letter`, and the strokes alone as strokes.svg:
the same letter in a lighter weight. The program is that of the variable QUENCH_PROGRAM, else `quench` of the PATH."""
import argparse
import os
import pathlib
import subprocess
import xml.etree.ElementTree as xml

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument('-o', '--output', type=pathlib.Path, default='.')
options = parser.parse_args()
options.output.mkdir(parents=True, exist_ok=True)

OUTLINE = (
    'M60 640 L100 60 H350 C520 60 610 140 610 250 C610 345 550 410 450 435 '
    'L595 557 A58 58 0 0 1 515 641 L330 442 H205 L190 640 Z '
    'M210 140 V365 H335 C440 365 505 325 505 250 C505 180 440 140 340 140 Z'
)
HEAD = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 720 740">'
file, out = options.output / 'letter.svg', options.output / 'letter'
file.write_text(f'{HEAD}<path fill-rule="evenodd" d="{OUTLINE}"/></svg>\n', encoding='utf-8')
program = os.environ.get('QUENCH_PROGRAM', 'quench')
subprocess.run([program, 'run', file, '-o', out, '--overwrite', '--quiet'], check=True)

print('stroke  length  width')
strokes = []
for number, line in enumerate(xml.parse(out / 'skeleton.svg').iter('{http://www.w3.org/2000/svg}polyline')):
    length, width = float(line.get('data-length')), 2 * float(line.get('data-mean-radius'))
    print(f'{number:6} {length:7.1f} {width:6.1f}')
    strokes.append(f'<polyline points="{line.get("points")}"/>')
style = 'fill="none" stroke="black" stroke-width="24" stroke-linecap="round" stroke-linejoin="round"'
text = '\n'.join([f'{HEAD}<g {style}>', *strokes, '</g></svg>\n'])
(options.output / 'strokes.svg').write_text(text, encoding='utf-8')
