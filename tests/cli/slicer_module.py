# SPDX-License-Identifier: Apache-2.0
"""Commands as command line modules of 3D Slicer: their descriptions against a schema and the help of the command, and
modules called as Slicer does it: every parameter with its value, files by their flags, a file for returned numbers.

slicer_module.py PROGRAM      ends with 77, skipped, without xmllint (libxml2-utils), which is only the schema's
"""
import gzip
import json
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

HERE = os.path.dirname(os.path.abspath(__file__))
SCHEMA = os.path.join(HERE, 'slicer_module.xsd')
SKIPPED = 77
BULK = ('image', 'geometry', 'table')
# What help shows and Slicer has no use for: formats and pictures, polygons and images, words for a terminal.
NOT_OFFERED = {'help', 'xml', 'json', 'overwrite', 'quiet', 'verbose', 'output', 'units', 'pixel', 'feature', 'channel',
               'dimension', 'no-view', 'no-picture', 'max-triangles', 'swc-type', 'narrower', 'extend', 'shape', 'columns',
               'csv', 'png', 'page'}


class Parameter:
    """What Slicer keeps of a parameter; `value` is what the user would see."""

    def __init__(self, node):
        def text(name):
            return (node.findtext(name) or '').strip()

        self.tag, self.name, self.channel = node.tag, text('name'), text('channel')
        self.flag = text('longflag').lstrip('-')
        self.value = text('default')
        self.elements = [element.text for element in node.findall('element')]
        self.extension = (node.get('fileExtensions') or '').split(',')[0]
        self.range = [float(limit.text) for limit in node.findall('constraints/*')][:2]

    @property
    def returned(self):
        return self.channel == 'output' and self.tag not in BULK and not self.flag


class Module:
    """A module as Slicer knows it once it has asked for its description."""

    def __init__(self, *command):
        self.command = command
        done = subprocess.run([*command, '--xml'], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              check=False)
        assert done.returncode == 0 and done.stderr == b'' and done.stdout.startswith(b'<?xml'), done
        self.xml = done.stdout
        root = xml.etree.ElementTree.fromstring(done.stdout)
        self.title = root.findtext('title')
        self.parameters = [Parameter(node) for group in root.findall('parameters') for node in group
                           if node.tag not in ('label', 'description')]

    def __getitem__(self, name):
        return next(parameter for parameter in self.parameters if parameter.name == name)

    def line(self, values, folder, prefix=''):
        """The command line for values that the user has set: names of files of inputs, True for outputs that are wanted;
        and the files that Slicer would read afterwards."""
        words, outputs = list(self.command), {}
        if any(parameter.returned for parameter in self.parameters):
            outputs['return'] = os.path.join(folder, prefix + 'returned.params')
            words += ['--returnparameterfile', outputs['return']]
        for parameter in self.parameters:
            if parameter.returned:
                continue
            value = values.get(parameter.name, parameter.value)
            if parameter.tag in BULK:
                if not value:
                    continue
                if parameter.channel == 'output':
                    value = outputs[parameter.name] = os.path.join(folder, prefix + parameter.name + parameter.extension)
                words += ['--' + parameter.flag, value]
            elif parameter.tag == 'boolean':
                words += ['--' + parameter.flag] if str(value).lower() == 'true' else []
            elif parameter.tag == 'point':
                for point in value or ():
                    words += ['--' + parameter.flag, ','.join(map(str, point))]
            elif parameter.tag == 'string':
                words += ['--' + parameter.flag, value] if value else []
            else:
                words += ['--' + parameter.flag, str(value)]
        return words, outputs

    def call(self, values, folder, prefix='', code=0):
        """What Slicer has after a call: its outputs, returned numbers, the text that is left of stdout, and stderr."""
        words, outputs = self.line(values, folder, prefix)
        done = subprocess.run(words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                              check=False)
        assert done.returncode == code, (words, done)
        text = done.stdout
        if code == 0:
            progress = [float(number) for number in re.findall('<filter-progress>([^<]*)</filter-progress>', text)]
            assert progress == sorted(progress) and progress[-1] == 1 and progress[0] >= 0, progress
            assert text.startswith('<filter-start>') and text.rstrip().endswith('</filter-end>'), text
            assert all(0 <= float(n) <= 1 for n in re.findall('<filter-stage-progress>([^<]*)<', text))
        for tag in ('progress', 'stage-progress', 'name', 'comment', 'time', 'start', 'end'):  # in Slicer's order
            text = re.sub(f'<filter-{tag}>[^<]*</filter-{tag}>[ \t\n\r]*', '', text)
        assert '<' not in text, text
        returned = {}
        if code == 0 and 'return' in outputs:
            with open(outputs.pop('return'), encoding='utf-8') as file:
                for line in file:
                    name, number = line.split('=')
                    assert self[name.strip()].returned, line
                    returned[name.strip()] = float(number)
        return outputs, returned, text, done.stderr


def check_description(module, program, command):
    if shutil.which('xmllint'):
        done = subprocess.run(['xmllint', '--noout', '--schema', SCHEMA, '-'], input=module.xml, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, check=False)
        assert done.returncode == 0, done.stdout.decode()
    for parameter in module.parameters:
        assert not parameter.elements or parameter.value in parameter.elements, parameter.name
        assert not parameter.range or parameter.range[0] <= float(parameter.value) <= parameter.range[1], parameter.name
    help_text = subprocess.run([program, command, '--help'], stdout=subprocess.PIPE, text=True, check=True).stdout
    options = re.findall(r'^ +(?:-\w,)?--([\w-]+)(?:,--[\w-]+)?(?: ([^\s=]+)(?:=(\S+))?)?', help_text, re.M)
    assert len(options) > 30
    flags = {parameter.flag: parameter for parameter in module.parameters if parameter.flag}
    for name, _, default in options:
        if name in NOT_OFFERED:
            continue
        parameter = flags[name.replace('-', '_')]
        assert parameter.value in (default, 'default' if not default else default, 'false' if not default else default), \
            (name, parameter.value, default)


def write_volume(path):
    """A tube with a branch: 40 x 24 x 24 voxels of 0.5 x 0.5 x 1 mm, as Slicer writes it: along the axes of the patient
    to the left, to the front and up, far from the origin."""
    nx, ny, nz = 40, 24, 24
    samples = bytearray(nx * ny * nz)
    for z in range(nz):
        for y in range(ny):
            for x in range(nx):
                stem = 3 <= x < 37 and (y - 8) ** 2 + (z - 10) ** 2 <= 16
                branch = 8 <= y < 22 and (x - 20) ** 2 + (z - 10) ** 2 <= 9
                samples[x + nx * (y + ny * z)] = stem or branch
    header = ('NRRD0004\ntype: unsigned char\ndimension: 3\nspace: left-posterior-superior\nsizes: 40 24 24\n'
              'space directions: (0.5,0,0) (0,-0.5,0) (0,0,1)\nkinds: domain domain domain\nendian: little\n'
              'encoding: gzip\nspace origin: (100,50,-20)\n\n')
    with open(path, 'wb') as file:
        file.write(header.encode() + gzip.compress(bytes(samples), 1))


def bounds_of(program, file):
    done = subprocess.run([program, 'info', file, '--json'], stdout=subprocess.PIPE, text=True, check=True)
    found = json.loads(done.stdout)
    return found.get('bounds') or found.get('box') or found


def header_of(path):
    with open(path, 'rb') as file:
        return file.read().split(b'\n\n')[0].decode()


def read_bytes(path):
    with open(path, 'rb') as file:
        return file.read()


def check_calls(modules, program, folder):
    volume = os.path.join(folder, 'tube.nrrd')
    write_volume(volume)
    # All outputs of each; files that are there are replaced, as Slicer uses its names again.
    for _ in range(2):
        outputs, returned, text, said = modules['run'].call(
            {'volume': volume, 'core': True, 'skeleton': True, 'branches': True, 'sheets': True}, folder)
    assert said == '' and 'skeleton' in text and 'quench-' not in text, (said, text)  # names of files that are gone
    assert returned == {'components': 1, 'tunnels': 0, 'cavities': 0}, returned
    for name in ('core', 'skeleton'):
        assert b'Name="SPACE"' in read_bytes(outputs[name])
    assert read_bytes(outputs['branches']).startswith(b'branch,')
    assert sorted(os.listdir(folder)) == sorted(['tube.nrrd', 'returned.params', *map(os.path.basename, outputs.values())])
    skeleton = outputs['skeleton']

    outputs, returned, text, said = modules['tree'].call(
        {'volume': volume, 'kind': 'vessel', 'root': [(119, 46, -10)], 'centerlines': True, 'edited': True,
         'branches_table': True, 'axes_table': True, 'traits_table': True}, folder, 'tree_')
    assert said == '' and returned['number_of_branches'] == 3 and returned['number_of_axes'] == 2, (said, returned)
    assert all(name in read_bytes(outputs['centerlines']) for name in (b'Name="SPACE"', b'Name="Radius"'))
    assert 'space: left-posterior-superior' in header_of(outputs['edited'])

    outputs, returned, text, said = modules['thickness'].call(
        {'volume': volume, 'thickness': True, 'surface': True, 'summary': True, 'histogram': True}, folder, 'thick_')
    assert said == '' and 3 < returned['mean'] < returned['largest'] < 6, returned
    header = header_of(outputs['thickness'])
    assert 'space: left-posterior-superior' in header and '(0,-0.5,0)' in header and '(100,50,-20)' in header, header
    assert b'Name="SPACE"' in read_bytes(outputs['surface'])
    # A model, which keeps what it says of its space; values that exclude each other, when one is not the default.
    outputs, _, _, said = modules['run'].call(
        {'model': outputs['surface'], 'resolution': '32', 'lambda': '5%', 'theta2': 'inf', 'longest': True, 'skeleton': True,
         'folder': os.path.join(folder, 'all')}, folder, 'model_')
    assert said == '' and b'Name="SPACE"' in read_bytes(outputs['skeleton'])
    assert os.path.exists(os.path.join(folder, 'all', 'report.json'))

    # Errors: one sentence on stderr, and a code that is not 0.
    for values, code, words in (({'core': True}, 2, 'volume or a model'), ({'volume': volume}, 2, 'output'),
                                ({'volume': skeleton, 'core': True, 'threshold': 'much'}, 2, 'much'),
                                ({'volume': os.path.join(folder, 'none.nrrd'), 'core': True}, 1, 'none.nrrd')):
        _, _, _, said = modules['run'].call(values, folder, 'bad_', code)
        assert said.startswith('quench: ') and said.count('\n') == 1 and words in said, said
    done = subprocess.run([program, 'slicer-module', 'run', '--no_such', '1'], stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 2 and '--no_such' in done.stderr, done


def main():
    program = os.path.abspath(sys.argv[1])
    assert struct.calcsize('d') == 8
    modules = {}
    for command in ('run', 'tree', 'thickness'):
        modules[command] = Module(program, 'slicer-module', command)
        assert Module(program, command).xml == modules[command].xml
        check_description(modules[command], program, command)
    with tempfile.TemporaryDirectory() as folder:
        check_calls(modules, program, folder)
    if not shutil.which('xmllint'):
        print('skipped: xmllint is not installed; all but the schema was checked')
        return SKIPPED
    return 0


if __name__ == '__main__':
    sys.exit(main())
