# SPDX-License-Identifier: Apache-2.0
"""Runs every command of Quench on samples and real data and compares the hashes of all it writes with the stored ones,
so that a change that should change no byte can be shown to change none.

output_hashes.py [--program QUENCH] [--data FOLDER] [--write] [--only PATTERN] [--keep FOLDER] [--built-by TEXT] [--list]

output_hashes.txt holds a line per output: the first 16 digits of its SHA-256 and CASE/FILE. Every case runs in an empty
folder of its own, with one and with two threads, which must give the same bytes. What a command prints on stdout is an
output too (NUMBER_COMMAND.stdout); stderr is not. What may differ between two runs is taken out in normalised() below.
A change that is meant to change outputs rewrites the hashes with --write; `git diff` then says which.

QUENCH_TEST_FULL=1 adds larger cases. Cases on real data are left out, and counted, where ../shared/data (--data) is absent.
Ends with 77, skipped, where bytes may differ for another reason: another compiler, libm or zlib than the hashes were
made with, or a program without the interactive page.
"""
import argparse
import collections
import fnmatch
import hashlib
import math
import os
import platform
import re
import shlex
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [os.path.join(HERE, 'cli'), os.path.join(HERE, 'support')]
import reports  # noqa: E402
from program_starter import run_program  # noqa: E402

STORED = os.path.join(HERE, 'output_hashes.txt')
FULL = os.environ.get('QUENCH_TEST_FULL') == '1'
SKIPPED = 77
REPORT = reports.AnyReport()
LIMIT = ['--memory-limit', '64G']  # far above what any case needs: nothing depends on the memory that is free
PAGES = 'all_pages/program'  # the output that stands for the program inside of every page

Setting = collections.namedtuple('Setting', 'program version data')
# A case runs `lines` (arguments of quench; a line that begins with 4: ends with exit code 4) in a folder where `data`,
# files of the real data, lie under their own names.
Case = collections.namedtuple('Case', 'name lines data', defaults=[()])

# --------------------------------------------------------------------------------------------------------------- cases

# The resolution at which a sample is small and still has a medial axis.
SAMPLES = {'ellipsoid': 32, 'torus': 32, 'box': 28, 'rippled-box': 32, 'bumpy-sphere': 24, 'fin-on-board': 32,
           'four-blobs': 40, 'plate-with-holes': 48, 'hollow-sphere': 18, 'bead-pack': 18, 'rough-plate': 48, 'bars': 160,
           'root': 64}
PICTURED = ['fin-on-board', 'hollow-sphere', 'bars', 'root']  # the others have their page and picture in the full run
BARE = '--no-view --no-picture'
MESHES = {'bunny_closed.off': f'--resolution 32 {BARE}', 'armadillo.off': f'--resolution 48 {BARE}',
          'fandisk.off': '--resolution 40',
          'truck.obj': '--resolution 32 --fill auto'}
VOLUMES = {'Al.100.vol': '', 'torsoLabel.nii.gz': '--label 5', 'emd_5625.map': '--threshold 1.991'}
LARGE_VOLUMES = {'maize_root_ct.nrrd': '--threshold 14 --largest-component', 'xyz-dragon-256.vol': '',
                 'lobster.vol': '--threshold 80', 'trabecular_bone_128.nrrd': '--threshold 143 --min-component 20'}
IMAGES = {'horse.png': '--threshold 128 --invert', 'mpeg7_beetle-1.png': '', 'retina_DRIVE_22_vessels.png': '',
          'icon_oak.svg': ''}
POLYGONS = ['ne_110m_lakes.json', 'ne_110m_land.json']
FILLS = ['nonzero', 'evenodd', 'winding', 'auto']
COMMANDS = ['run', 'tree', 'batch', 'sample', 'voxelize', 'core', 'burn', 'skeleton', 'parts', 'thickness', 'reconstruct', 'simplify',
            'smooth', 'view', 'info', 'convert', 'verify']


def main_job(shape, options):
    """The lines of the main job on a shape and of the checks of its results."""
    return [f'run {shape} {options} -o out', f'verify {shape} out/core.vtp out/skeleton.vtp --json verified.json',
            'info out/core.vtp', 'info out/skeleton.vtp --json']


def sample_cases():
    for name, resolution in SAMPLES.items():
        yield Case(f'sample_{name}', [f'sample {name} -o mesh.ply', f'sample {name} --fineness 0.25 -o obj.obj',
                                      f'sample {name} --fineness 0.25 -o vtp.vtp',
                                      f'sample {name} --resolution {resolution} -o volume.nrrd'])
        bare = '' if name in PICTURED else f' {BARE}'
        if name == 'bead-pack':  # its mesh is large at any fineness: it is voxelized in shape_fill, and run in the full run
            lines = [f'sample {name} --resolution {resolution} -o {name}.nrrd', *main_job(f'{name}.nrrd', bare.strip())]
        else:
            lines = [f'sample {name} --fineness 0.25 -o {name}.ply', *main_job(f'{name}.ply', f'--resolution {resolution}{bare}')]
        yield Case(f'run_{name}', lines)
    yield Case('sample_options', ['sample root --seed 7 --branches 20 -o root.ply', 'info root.ply',
                                  'sample rough-plate --seed 3 --noise 0.01 --fineness 0.5 -o plate.ply',
                                  'sample rippled-box --noise 0.02 --fineness 0.5 -o box.ply',
                                  'sample bumpy-sphere --noise 0.05 --fineness 0.5 -o sphere.obj',
                                  'sample bead-pack --seed 5 --fineness 0.5 -o beads.ply'])


def help_case():
    return Case('help', ['--help', '--version', *(f'{command} --help' for command in COMMANDS)])


def step_lines(shape, options):
    """Every command, one step after the other, in every format."""
    lines = [f'voxelize {shape} {options} -o voxels.nrrd --json voxelize.json',
             f'core {shape} {options} -o core.vtp --json core.json', f'core {shape} {options} --full -o full.vtp',
             f'core {shape} {options} --lambda 0 --surface voxels -o whole.ply']
    lines += [f'core {shape} {options} -o core.{e}' for e in ('ply', 'obj', 'ma', 'r', 'csv')]
    lines += ['burn core.vtp -o burned.vtp --json burn.json', 'burn core.vtp -o burned.ply', 'burn core.vtp -o burned.csv']
    lines += ['skeleton burned.vtp -o skeleton.vtp --swc tree.swc --graphml graph.graphml --csv branches.csv '
              '--json skeleton.json']
    lines += [f'skeleton core.vtp -o skeleton.{e}' for e in ('ply', 'obj', 'csv')]
    lines += [f'view burned.vtp --shape {shape} -o page.html --json view.json', 'view skeleton.vtp']
    lines += [f'convert burned.vtp copy.{e}' for e in ('vtp', 'vtu', 'ply', 'obj', 'stl', 'ma', 'r', 'csv')]
    lines += ['convert skeleton.vtp quality.ply --quality erosion_thickness', 'convert core.ma from_ma.vtp',
              'convert core.obj from_obj.vtp --radii core.r', 'convert burned.ply from_ply.obj']
    files = [shape, 'voxels.nrrd', 'core.vtp', 'core.ma', 'core.obj', 'burned.ply', 'skeleton.vtp']
    lines += [f'info {file}{json}' for file in files for json in ('', ' --json')]
    lines += [f'verify {shape} core.vtp burned.vtp skeleton.vtp', f'verify {shape} full.vtp --json -',
              f'verify {shape} {options} whole.ply --core --samples 500 --json verified.json']
    return lines


def step_cases():
    for case, name, resolution in (('steps', 'fin-on-board', 28), ('steps', 'root', 64), ('full_steps', 'torus', 32)):
        shape = f'{name}.ply'
        yield Case(f'{case}_{name}', [f'sample {name} --fineness 0.25 -o {shape}',
                                      *step_lines(shape, f'--resolution {resolution}')])
    yield Case('steps_volume', ['sample four-blobs --resolution 40 -o blobs.nrrd', *step_lines('blobs.nrrd', '--threshold 1')])


CORE_OPTIONS = ['--lambda 0', '--lambda auto', '--detail 0', '--detail 2vox', '--detail inf', '--lambda 0.05',
                '--lambda 3%', '--lambda 2.5vox', '--lambda 0.1abs', '--lambda inf', '--lambda-rule ball', '--full',
                '--full --lambda 1.5vox --lambda-rule ball', '--measures mgf', '--prune-by mgf=10vox', '--prune-by core_erosion_thickness=2vox',
                '--prune-by scale_axis=1.3 --surface voxels', '--detail 0 --measures all']
BURN_OPTIONS = ['--omega 0.005', '--omega 0.5vox', '--omega 0.04abs', '--omega 2%', '--radius linear',
                '--radius linear --omega 0.01', '--propagation windows', '--propagation windows --omega 0.02 --radius linear']
SKELETON_OPTIONS = ['--theta2 inf', '--theta2 0', '--theta2 8%', '--theta1 0', '--theta1 inf', '--theta1 2vox', '--full',
                    '--smooth 0', '--smooth 50 --resample 0.02', '--tips pruned', '--root 0,0,9 --swc-type axon',
                    '--omega 0.02 --theta2 inf', '--radius linear --theta2 0.05', '--omega 0.01',
                    '--propagation windows --theta2 inf']
VIEW_OPTIONS = ['--theta2 inf --theta1 0.1 --dark', '--layer core --color lambda --detail 0.05', '--max-triangles 2000',
                '--camera 1,2,3,0,0,0,0,0,1 --color radius', '--omega 0.02']


PARTS_OPTIONS = ['--remesh 3vox', '--remesh 8%', '--theta2 8% --tips pruned', '--whole', '--smooth 0']


def numbered(command, options, output):
    """A line per option: `output` names what it writes and may name its number."""
    return [f'{command} {text} {output.format(i)}' for i, text in enumerate(options, 1)]


def option_cases():
    fin, root = 'sample fin-on-board --fineness 0.25 -o fin.ply', 'sample root --fineness 0.25 -o root.ply'
    both = '-o result_{0}.vtp --json result_{0}.json'
    graphs = both + ' --swc tree_{0}.swc --graphml graph_{0}.graphml --csv branches_{0}.csv'
    yield Case('options_core', [fin, *numbered('core fin.ply --resolution 28', CORE_OPTIONS, both)])
    for name, sample, resolution in (('fin', fin, 32), ('root', root, 48)):
        core = [sample, f'core {name}.ply --resolution {resolution} -o core.vtp']
        yield Case(f'options_burn_{name}', core + numbered('burn core.vtp', BURN_OPTIONS, both))
        yield Case(f'options_skeleton_{name}', core + numbered('skeleton core.vtp', SKELETON_OPTIONS, graphs))
    yield Case('options_parts', [fin, 'core fin.ply --resolution 28 -o core.vtp', 'parts fin.ply --resolution 28 -o parts',
                                 *numbered('parts core.vtp', PARTS_OPTIONS, '-o sheets_{0}.vtp --csv sheets_{0}.csv'),
                                 *[f'parts core.vtp -o all.{e}' for e in ('vtu', 'ply', 'obj', 'stl')]])
    yield Case('options_solid', [fin, 'core fin.ply --resolution 28 -o core.vtp',
                                 *[f'thickness fin.ply --resolution 24 -o thickness.{e}' for e in ('nrrd', 'nii.gz', 'tif', 'npy')],
                                 'thickness fin.ply --resolution 24 --surface surface.ply --csv t.csv --histogram h.csv --json t.json',
                                 'thickness fin.ply --resolution 24 --invert --balls vertices -o pores.nrrd --csv pores.csv',
                                 'reconstruct core.vtp -o balls.nrrd --json balls.json',
                                 'reconstruct core.vtp --envelope --shape fin.ply -o solid.ply --json solid.json',
                                 'simplify core.vtp --vertices 60 --shape fin.ply -o few.ma --levels few.csv --json few.json',
                                 'simplify core.vtp --error 6% --shape fin.ply -o near.vtp', 'smooth core.vtp -o smooth.vtp'])
    yield Case('options_view', [fin, 'core fin.ply --resolution 24 -o core.vtp',
                                *numbered('view core.vtp --shape fin.ply', VIEW_OPTIONS, '-o page_{0}.html'),
                                'view core.vtp -o page.html', 'convert core.vtp core.obj', 'view core.obj -o still.html'])
    run_root, run_fin = 'run root.ply --resolution 64', 'run fin.ply --resolution 24'
    yield Case('options_run', [root, fin,
                               f'{run_root} --theta2 inf --tips pruned --smooth 0 --resample 0.01 --no-view -o curves',
                               f'{run_root} --lambda 1vox --root 0,0,1 --swc-type 7 --max-triangles 3000 -o small_page',
                               f'{run_fin} --full --radius linear --omega 0.01 -o linear',
                               f'{run_fin} --lambda 2% --theta1 0 --theta2 5% --json report.json -o other'])


def foreign_axis_case():
    """What other programs write: no stage, no sites; radii beside it; a shape to measure by."""
    core, sized = 'core blobs.ply --resolution 48', '--shape blobs.ply'
    return Case('foreign_axis', ['sample four-blobs --fineness 0.25 -o blobs.ply',
                                 *(f'{core} -o core.{e}' for e in ('obj', 'r', 'ma')),
                                 'burn core.obj --radii core.r -o burned.vtp --json burned.json',
                                 f'burn core.ma {sized} -o sized.vtp',
                                 f'skeleton core.ma {sized} -o skeleton.vtp --swc tree.swc',
                                 f'view core.ma {sized} --resolution 48 -o page.html',
                                 # Its radii between vertices are linear, and so no distances.
                                 '4: verify blobs.ply --resolution 48 skeleton.vtp --json verified.json'])


def shape_cases():
    """Options that say what the shape is."""
    volume = ['sample hollow-sphere --resolution 20 -o v.nrrd', 'sample four-blobs --resolution 40 -o b.nrrd']
    options = ['v.nrrd --fill-cavities', 'v.nrrd --invert', 'v.nrrd --invert --largest-component',
               'v.nrrd --invert --min-component 2000', 'v.nrrd --subdivide 2', 'v.nrrd --label 0',
               'v.nrrd --label 1 --spacing 0.5,0.5,2', 'b.nrrd --threshold 1 --spacing 3', 'b.nrrd --subdivide 3']
    yield Case('shape_volume', [*volume, *numbered('voxelize', options, '-o voxels_{0}.nrrd --json voxels_{0}.json'),
                                *numbered('core', options[:7], '-o core_{0}.vtp --json core_{0}.json'),
                                *(f'verify {text} core_{i}.vtp' for i, text in enumerate(options[:7], 1))])
    yield Case('shape_run', [*volume, 'run v.nrrd --invert --fill-cavities -o inverted',
                             'run b.nrrd --spacing 1,1,2.5 --subdivide 2 -o split'])
    yield Case('shape_fill', ['sample bead-pack --fineness 0.25 -o beads.ply', 'sample torus --fineness 0.5 -o torus.obj',
                              *(f'voxelize {file} --resolution 32 --fill {fill} -o {file}_{fill}.nrrd --json {file}_{fill}.json'
                                for file in ('beads.ply', 'torus.obj') for fill in FILLS),
                              'voxelize torus.obj --resolution auto -o auto.nrrd --json auto.json'])


def not_verified_case():
    return Case('not_verified', ['sample box -o box.ply', 'sample ellipsoid --fineness 0.25 -o other.ply',
                                 'core box.ply --resolution 32 -o core.vtp', '4: verify other.ply core.vtp',
                                 '4: verify other.ply core.vtp --json failed.json'])


def data_cases():
    for file, options in MESHES.items():
        yield Case('data_' + file.split('.')[0], main_job(file, options), [f'meshes/{file}'])
    for file, options in VOLUMES.items():
        yield Case('data_' + file.split('.')[0], main_job(file, options), [f'volumes/{file}'])
    yield Case('full_steps_fandisk', step_lines('fandisk.off', '--resolution 48'), ['meshes/fandisk.off'])
    yield Case('data_defective', [f'voxelize truck.obj --resolution 40 --fill {fill} -o {fill}.nrrd --json {fill}.json'
                                  for fill in FILLS[:3]], ['meshes/truck.obj'])


def plane_cases():
    """Images and polygons."""
    for file, options in IMAGES.items():
        yield Case('plane_' + re.sub(r'\W', '_', file.split('.')[0]), main_job(file, options), [f'images/{file}'])
    for file in POLYGONS:
        yield Case('plane_' + file.split('.')[0], [f'info {file} --json', f'run {file} --resolution 160 -o all'],
                   [f'images/{file}'])
    horse = 'horse.png --threshold 128 --invert'
    yield Case('plane_steps', [
        f'voxelize {horse} -o pixels.nrrd --json voxelize.json', 'core pixels.nrrd -o core.vtp --json core.json',
        f'core {horse} --full -o full.vtp', f'core {horse} --lambda 2vox --subdivide 2 --spacing 1,1.5 -o fine.vtp',
        'burn core.vtp -o burned.vtp --json burn.json',
        'skeleton burned.vtp -o skeleton.vtp --geojson s.geojson --svg s.svg --wkt s.wkt --csv s.csv --json skeleton.json',
        'view burned.vtp --shape pixels.nrrd -o page.html', 'view skeleton.vtp --png picture.png',
        f'run {horse} --longest --extend -o longest', f'run {horse} --narrower 20abs --theta1 0.2r -o narrower',
        'run ne_110m_lakes.json --feature 3 --pixel 0.01 -o lake',
        f'verify {horse} full.vtp core.vtp longest/skeleton.vtp narrower/core.vtp --json verified.json',
        'verify horse.png fine.vtp'],
        ['images/horse.png', 'images/ne_110m_lakes.json'])


def tree_cases():
    """Trees, and volumes made ready."""
    damaged = 'sample root --branches 20 --grey --touching 2 --gaps 2 --blur 0.6 --noise 0.05 --resolution 96 -o root.nrrd'
    yield Case('tree_root', [
        damaged, 'info root.nrrd', 'tree root.nrrd -o out', 'tree root.nrrd --threshold 100 --axes length --columns toporoot '
        '--repair all --no-view -o other', 'tree out/tree.rsml --no-view -o again', 'info out/tree.swc --json',
        *(f'convert out/tree.swc tree.{e}' for e in ('rsml', 'mtg', 'graphml', 'vtp')), 'convert out/tree.rsml back.swc',
        'info out/edited.nrrd'])
    yield Case('tree_prepared', [
        damaged, 'run root.nrrd --blur 0.5 --median 1 --threshold 90,120 --connectivity 26 --close 1 --no-view -o ready',
        'verify root.nrrd ready/core.vtp ready/skeleton.vtp', 'voxelize root.nrrd --threshold otsu -o otsu.nrrd',
        'voxelize root.nrrd --threshold auto --interpolate --spacing 1,1,2 -o cubes.nrrd'])
    yield Case('tree_files', [line for file in ('neurom_test_morph.swc', 'ds_1_cell_390.swc', 'bean-basal.rsml')
                              for line in (f'info {file}', f'tree {file} --kind neuron --no-view -o {file[:4]}')],
               ['trees/neurom_test_morph.swc', 'trees/ds_1_cell_390.swc', 'trees/bean-basal.rsml'])


def full_cases():
    yield Case('full_bricks', ['sample box -o box.ply',
                               'core box.ply --resolution 512 --in-bricks -o core.vtp --json core.json'])
    for name in SAMPLES:
        resolution = {'bead-pack': 48, 'bars': 320}.get(name, 128)
        yield Case(f'full_{name}', [f'sample {name} -o {name}.ply', *main_job(f'{name}.ply', f'--resolution {resolution}')])
    for file, options in MESHES.items():
        options = re.sub(r'--resolution \d+', '--resolution 128', options).replace(f' {BARE}', '')
        yield Case('full_' + file.split('.')[0], main_job(file, options), [f'meshes/{file}'])
    for file, options in LARGE_VOLUMES.items():
        yield Case('full_' + file.split('.')[0], main_job(file, options), [f'volumes/{file}'])


def all_cases():
    cases = [help_case(), *sample_cases(), *step_cases(), *option_cases(), foreign_axis_case(), *shape_cases(),
             not_verified_case(), *data_cases(), *plane_cases(), *tree_cases(), *full_cases()]
    assert len({case.name for case in cases}) == len(cases), 'two cases of one name'
    return cases


# ------------------------------------------------------------------------------------------- what may differ between runs

VERSION = b'VERSION'
REPORTS = [
    # How long it took, and how much memory: of every run its own. The stages stay.
    (re.compile(rb'("seconds": \{)([^}]*)'), lambda m: m[1] + re.sub(rb': [-+.\de]+', b': 0', m[2])),
    # The prediction is at least what the process has used so far.
    (re.compile(rb'("(?:peak|predicted)_bytes": )\d+'), rb'\g<1>0'),
    # The number of threads: both must give the same otherwise.
    (re.compile(rb'("threads": )\d+'), rb'\g<1>0'),
    # The size of the page: with the program of the page, which is hashed apart, and the command line.
    (re.compile(rb'("bytes": )\d+'), rb'\g<1>0'),
]
# What the test itself adds to every command line, which pages repeat.
ADDED = re.compile(rb' (--threads \d+|--memory-limit 64G)(?![^\s"])')
PAGE_DATA = re.compile(rb'<script type="application/json" id="quench-meta">.*?</script>\s*'
                       rb'<script type="application/octet-stream" id="quench-data">[^<]*</script>', re.DOTALL)


def text_without(text, version):
    """A release changes its number; other outputs do not hold three numbers with two dots."""
    return re.sub(rb'(?<![\d.])' + re.escape(version) + rb'(?![\d.])', VERSION, text)


def vtp_without(data):
    """VTP: all arrays as they are in the file but the one that holds the version, and no offsets, which depend on it."""
    head, mark, appended = data.partition(b'<AppendedData encoding="raw">')
    start = appended.index(b'_') + 1
    arrays = [(int(m[2]), m[1]) for m in re.finditer(rb'<\w+ [^>]*Name="([^"]*)"[^>]* offset="(\d+)"', head)]
    ends = [offset for offset, _ in arrays[1:]] + [len(appended) - start]
    kept = [appended[start + at:start + end] for (at, name), end in zip(arrays, ends) if name != b'version']
    return re.sub(rb' offset="\d+"', b'', head) + mark + appended[:start] + b''.join(kept)


def normalised(name, data, version):
    """The bytes that are hashed of an output, and the program of the page if it is one: it is the same in all pages, comes
    from viewer/ and not from the program, and is hashed once."""
    kind = os.path.splitext(name)[1]
    if kind == '.nrrd':
        return data, None
    if kind == '.vtp':
        return vtp_without(data), None
    if kind == '.ply':  # binary behind its header
        head, mark, body = data.partition(b'end_header\n')
        return text_without(head, version) + mark + body, None
    if kind == '.html':
        of_result = PAGE_DATA.search(data)
        meta, mark, arrays = (of_result[0] if of_result else data).partition(b'id="quench-data"')
        return ADDED.sub(b'', text_without(meta, version)) + mark + arrays, PAGE_DATA.sub(b'', data)
    data = text_without(data, version)
    if kind in ('.json', '.stdout'):
        for pattern, replacement in REPORTS:
            data = pattern.sub(replacement, data)
    return data, None


# ------------------------------------------------------------------------------------------------------------------ runs

def hash_of(data):
    return hashlib.sha256(data).hexdigest()[:16]


def run_line(program, line, number, threads, folder):
    """Runs one line; what it prints becomes a file. Returns what is wrong, if anything."""
    code, words = (4, line[2:]) if line.startswith('4:') else (0, line)
    words = shlex.split(words)
    if not words[0].startswith('-'):
        words += ['--threads', str(threads)] + ([] if '--memory-limit' in words else LIMIT)
    run = run_program([program, *words], folder)
    if run.stdout:
        with open(os.path.join(folder, f'{number}_{words[0].strip("-")}.stdout'), 'wb') as out:
            out.write(run.stdout)
    if run.returncode != code:
        return f'quench {line} [{threads} threads]: exit {run.returncode}: {run.stderr.decode(errors="replace").strip()[-400:]}'
    return ''


def files_of(folder):
    """All files but the links to data, relative and in order."""
    found = [os.path.join(where, name) for where, _, names in os.walk(folder) for name in names]
    return sorted(os.path.relpath(file, folder) for file in found if not os.path.islink(file))


def hashes_of(case, setting, threads, folder):
    """CASE/FILE and hash of everything a case writes, and what is wrong with its runs."""
    os.makedirs(folder)
    for file in case.data:
        os.symlink(os.path.join(setting.data, file), os.path.join(folder, os.path.basename(file)))
    wrong = [run_line(setting.program, line, number, threads, folder) for number, line in enumerate(case.lines, 1)]
    hashes = {}
    for name in files_of(folder):
        with open(os.path.join(folder, name), 'rb') as file:
            raw = file.read()
        if os.path.splitext(name)[1] in ('.json', '.stdout'):
            wrong += [f'{case.name}/{name}: not as docs/report.schema.json says: {error}' for error in REPORT.errors(raw)]
        data, page = normalised(name, raw, setting.version)
        hashes[f'{case.name}/{name}'] = hash_of(data)
        if page is not None and hashes.setdefault(PAGES, hash_of(page)) != hash_of(page):
            wrong.append(f'{case.name}/{name}: its page has another program than those before')
    return hashes, [text for text in wrong if text]


def run_case(case, setting, base):
    """The hashes of a case, the same for one and two threads, and what is wrong."""
    found, wrong = [], []
    for threads in (1, 2):
        folder = os.path.join(base, f'{threads}_threads', case.name)
        hashes, failures = hashes_of(case, setting, threads, folder)
        found.append(hashes)
        wrong += failures
    one, two = found
    wrong += [f'{name}: with one thread {one.get(name, "missing")}, with two {two.get(name, "missing")}'
              for name in sorted({*one, *two}) if one.get(name) != two.get(name)]
    return one, wrong


# ---------------------------------------------------------------------------------------------------------------- stored

def probe():
    """What the bytes depend on beside the program. glibc has several sin, cos, exp ... and chooses by the processor; they
    differ in the last digit of few values. Python calls the same ones."""
    values = [0.0]
    for i in range(1, 20000):
        x = i * 0.00731
        values += [math.sin(x), math.cos(x), math.exp(-x), math.log(x), math.pow(x, 1 / 3), math.atan2(x, 7 - x),
                   math.acos(i / 20000)]
    packed = struct.pack(f'<{len(values)}d', *values)
    deflated = b''.join(zlib.compress(packed[:200000], level) for level in (1, 6))
    return {'processor': platform.machine(), 'libm': hash_of(packed), 'zlib': hash_of(deflated)}


def read_stored():
    """The stored probe and hashes."""
    made, hashes = {}, {}
    if not os.path.exists(STORED):
        return made, hashes
    with open(STORED, encoding='utf-8') as file:
        for line in file.read().splitlines():
            if line.startswith('# made with '):
                what, value = line[len('# made with '):].split(': ', 1)
                made[what] = value
            elif line and not line.startswith('#'):
                value, name = line.split('  ', 1)
                hashes[name] = value
    return made, hashes


def write_stored(made, hashes):
    lines = ['# SPDX-License-Identifier: Apache-2.0', '# Written by output_hashes.py --write; see there.']
    lines += [f'# made with {what}: {value}' for what, value in made.items()]
    lines += [f'{hashes[name]}  {name}' for name in sorted(hashes)]
    with open(STORED, 'w', encoding='utf-8') as file:
        file.write('\n'.join(lines) + '\n')


def differences(stored, found, names_of_cases):
    """A line for each output that is not as stored; only of cases that ran."""
    expected = {name: value for name, value in stored.items() if name.split('/')[0] in names_of_cases}
    return [f'{name}: was {expected.get(name, "not there")}, is {found.get(name, "missing")}'
            for name in sorted({*expected, *found}) if expected.get(name) != found.get(name)]


def reason_to_skip(made, now):
    for what, value in now.items():
        if made.get(what, value) != value:
            return (f'the stored hashes were made with another {what} ({made[what]}, here {value}), '
                    'with which the last digits of results may differ')
    return ''


# ------------------------------------------------------------------------------------------------------------------ main

def chosen_cases(pattern, folder):
    """The cases that run, and the number of those whose data is absent."""
    cases = [c for c in all_cases() if (fnmatch.fnmatch(c.name, pattern) if pattern else FULL or not c.name.startswith('full_'))]
    there = [c for c in cases if all(os.path.exists(os.path.join(folder, file)) for file in c.data)]
    return there, len(cases) - len(there)


def parsed_options():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--program', default=os.path.join(HERE, '..', 'build', 'release', 'quench'))
    parser.add_argument('--data', metavar='FOLDER', default=os.path.join(HERE, '..', '..', 'shared', 'data'), help='real data')
    parser.add_argument('--write', action='store_true', help='stores the hashes of what ran; those of other cases stay')
    parser.add_argument('--only', metavar='PATTERN', help='the cases of such names, e.g. "run_*"')
    parser.add_argument('--keep', metavar='FOLDER', help='a new folder that keeps all outputs')
    parser.add_argument('--built-by', metavar='TEXT', help='the compiler; compared with that of the stored hashes')
    parser.add_argument('--list', action='store_true', help='prints the cases and their commands')
    return parser.parse_args()


def run_all(cases, setting, keep):
    """The hashes of all cases, the program of the pages among them once, and what is wrong."""
    found, wrong = {}, []
    with tempfile.TemporaryDirectory() as temporary:
        base = keep or temporary
        for case in cases:
            hashes, failures = run_case(case, setting, os.path.abspath(base))
            page = hashes.get(PAGES)
            if page != found.get(PAGES, page) and page:
                failures.append(f'{case.name}: its pages have another program than those before')
            found = {**hashes, **found}
            wrong += failures
            if not keep:
                shutil.rmtree(os.path.join(temporary, '1_threads'))
                shutil.rmtree(os.path.join(temporary, '2_threads'))
    return found, wrong


def has_pages(program):
    run = subprocess.run([program, 'view', 'absent.vtp', '-o', 'absent.html'], capture_output=True)
    return b'built without its interactive page' not in run.stderr


def store(made, now, stored, found, ran):
    """What ran, and what did not run but was made with the same."""
    known = {PAGES.split('/')[0], *(case.name for case in all_cases())}
    kept = {name: value for name, value in stored.items() if name.split('/')[0] in known - ran}
    if reason_to_skip(made, now):
        kept = {}
    write_stored({**made, **now}, {**kept, **found})
    print(f'output_hashes: {len(found)} hashes of {len(ran)} cases written, {len(kept)} of other cases kept')


def main():
    options = parsed_options()
    data = os.path.abspath(options.data)
    cases, absent = chosen_cases(options.only, data)
    if not cases and not absent:
        print(f'no case has such a name: {options.only}; --list shows all', file=sys.stderr)
        return 2
    if options.list:
        print('\n'.join(f'{case.name}: quench {line}' for case in cases for line in case.lines))
        return 0
    made, stored = read_stored()
    now = {**({'compiler': options.built_by} if options.built_by else {}), **probe()}
    reason = reason_to_skip(made, now)
    if reason and not options.write:
        print(f'skipped: {reason}')
        return SKIPPED
    program = os.path.abspath(options.program)
    version = subprocess.run([program, '--version'], capture_output=True, check=True).stdout.split()[-1]
    if not has_pages(program):
        print('skipped: the program was built without the interactive page, which reports tell of')
        return SKIPPED
    found, wrong = run_all(cases, Setting(program, version, data), options.keep)
    print(''.join(f'FAIL {line}\n' for line in wrong), end='')
    left_out = f'; {absent} cases left out: no {data}' if absent else ''
    ran = {*(case.name for case in cases), *(name.split('/')[0] for name in found)}
    if options.write:
        if not wrong:
            store(made, now, stored, found, ran)
        return 1 if wrong else 0
    different = differences(stored, found, ran)
    print(''.join(f'{line}\n' for line in different), end='')
    print(f'output_hashes: {len(found)} outputs of {len(cases)} cases, {len(different)} not as stored, '
          f'{len(wrong)} failures{left_out}')
    return 1 if different or wrong else 0


if __name__ == '__main__':
    sys.exit(main())
