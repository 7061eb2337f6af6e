# SPDX-License-Identifier: Apache-2.0
"""The algorithms in QGIS, without windows: layers keep their places, attributes and reference systems, and the values are
those of the program."""
import os
import shutil
import subprocess
import sys
import tempfile

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
PROGRAM = os.environ.get('QUENCH') or shutil.which('quench')
# Debian's wrapper of qgis_process hands it an option that it does not know.
PROCESS = shutil.which('qgis_process.bin') or shutil.which('qgis_process')
EAST, NORTH = 500000.0, 5200000.0

RIVER = [
    (0, 370),
    (180, 430),
    (420, 400),
    (640, 470),
    (900, 440),
    (1180, 520),
    (1500, 480),
    (1494, 420),
    (1180, 450),
    (960, 380),
    (880, 200),
    (760, 0),
    (690, 30),
    (810, 230),
    (850, 370),
    (640, 400),
    (420, 330),
    (180, 360),
    (20, 305),
]
LAKE = [(1050, 60), (1250, 20), (1440, 110), (1400, 290), (1180, 320), (1060, 210)]
ISLAND = [(1200, 130), (1190, 210), (1300, 200), (1290, 120)]


# Two of an algorithm at a time in one process, and one that is stopped while its program says nothing.
AT_ONCE = r'''
import os, sys, threading, time
from qgis.core import (QgsApplication, QgsProcessingContext, QgsProcessingException, QgsProcessingFeedback,
                       QgsProcessingUtils)
sys.path.insert(0, sys.argv[1])
application = QgsApplication([], False)
application.initQgis()
from quench_processing import algorithms

class Wide(algorithms.Algorithm):
    """Waits until both have written; what each finds is its own."""
    met = threading.Barrier(2)

    def work(self, parameters, context, feedback, folder):
        with open(os.path.join(folder, 'quench_image.tif'), 'w') as file:
            file.write(parameters['NAME'])
        self.met.wait(20)
        with open(os.path.join(folder, 'quench_image.tif')) as file:
            return {'OUTPUT': (folder, file.read())}

found = {}
def one(name):
    found[name] = Wide().processAlgorithm({'NAME': name}, None, None)['OUTPUT']
both = [threading.Thread(target=one, args=(name,)) for name in 'ab']
for thread in both:
    thread.start()
for thread in both:
    thread.join()
assert [found[name][1] for name in 'ab'] == ['a', 'b'] and found['a'][0] != found['b'][0], found
for folder, _ in found.values():
    assert folder.startswith(QgsProcessingUtils.tempFolder()) and not os.path.exists(folder)

with open('silent', 'w') as file:
    file.write('#!/bin/sh\necho $$ >silent.pid\nexec sleep 60\n')
os.chmod('silent', 0o755)
os.environ['QUENCH'] = os.path.abspath('silent')
feedback = QgsProcessingFeedback()
threading.Timer(1.0, feedback.cancel).start()
start = time.time()
algorithm = algorithms.ThicknessOfImage()
algorithm.initAlgorithm()
try:
    algorithm.run_quench(['thickness'], {}, QgsProcessingContext(), feedback, os.getcwd())
except QgsProcessingException as error:
    assert 'cancelled' in str(error), error
else:
    raise AssertionError('it was stopped, and went on')
assert 0.8 < time.time() - start < 5, time.time() - start
with open('silent.pid') as file:
    number = int(file.read())
try:
    os.kill(number, 0)
except ProcessLookupError:
    pass
else:
    raise AssertionError('the program still runs')
print('at once: good')
sys.stdout.flush()
os._exit(0)  # QGIS does not always end well in a script
'''


class Failed(Exception):
    """qgis_process ended with an error."""


def process(folder, *words):
    """qgis_process with a profile of its own."""
    return run_in(folder, PROCESS, *words)


def run_in(folder, *words):
    environment = dict(
        os.environ,
        HOME=folder,
        XDG_RUNTIME_DIR=folder,
        QT_QPA_PLATFORM='offscreen',
        QGIS_PLUGINPATH=HERE,
        QUENCH=PROGRAM,
    )
    environment.pop('PYTHONPATH', None)
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, env=environment, timeout=300)
    if done.returncode:
        raise Failed(done.stdout + done.stderr)
    return done.stdout


def polygon_layer(file, ogr, osr, rings_of):
    system = osr.SpatialReference()
    system.ImportFromEPSG(32632)
    data = ogr.GetDriverByName('GPKG').CreateDataSource(file)
    layer = data.CreateLayer('waters', system, ogr.wkbPolygon)
    layer.CreateField(ogr.FieldDefn('name', ogr.OFTString))
    layer.CreateField(ogr.FieldDefn('length', ogr.OFTInteger))  # a name that branches have, too
    for name, number, rings in rings_of:
        feature = ogr.Feature(layer.GetLayerDefn())
        feature['name'], feature['length'] = name, number
        polygon = ogr.Geometry(ogr.wkbPolygon)
        for points in rings:
            ring = ogr.Geometry(ogr.wkbLinearRing)
            for x, y in [*points, points[0]]:
                ring.AddPoint_2D(EAST + x, NORTH + y)
            polygon.AddGeometry(ring)
        feature.SetGeometry(polygon)
        layer.CreateFeature(feature)
    return None


def check_polygons(folder, ogr, osr):
    waters = [('Ash', 7, [RIVER]), ('Ring Lake', 9, [LAKE, ISLAND])]
    for name, chosen, lines in (('waters', waters, {'Ash': 3, 'Ring Lake': 1}), ('one', waters[:1], {'Ash': 3})):
        polygon_layer(f'{folder}/{name}.gpkg', ogr, osr, chosen)
        process(
            folder,
            'run',
            'quench:centrelinesofpolygons',
            '--',
            f'INPUT={name}.gpkg',
            'PIXEL=2',
            'EXTEND=true',
            f'OUTPUT={name}_lines.gpkg',
        )
        source = ogr.Open(f'{folder}/{name}.gpkg')
        shapes = {feature['name']: feature.GetGeometryRef().Clone() for feature in source.GetLayer()}
        found = ogr.Open(f'{folder}/{name}_lines.gpkg')
        layer = found.GetLayer()
        assert layer.GetSpatialRef().GetAuthorityCode(None) == '32632'
        counts = {}
        for feature in layer:
            line = feature.GetGeometryRef()
            counts[feature['name']] = counts.get(feature['name'], 0) + 1
            assert shapes[feature['name']].Buffer(4).Contains(line), 'a line leaves its polygon'
            assert abs(line.Length() / feature['quench_length'] - 1) < 1e-6
            assert feature['length'] == {'Ash': 7, 'Ring Lake': 9}[feature['name']] and 15 < feature['mean_radius'] < 80
        assert counts == lines, counts
    print('polygons: 4 lines in their polygons, with attributes and reference system')


def check_image(folder, gdal, osr, ogr):
    row, column = np.indices((120, 200))
    bar = ((abs(row - 60) < 9) & (column > 10) & (column < 190)) | ((abs(column - 90) < 7) & (row > 8) & (row < 60))
    system = osr.SpatialReference()
    system.ImportFromEPSG(32632)
    place = (EAST, 0.5, 0, NORTH, 0, -0.5)
    image = gdal.GetDriverByName('GTiff').Create(f'{folder}/image.tif', 200, 120, 1, gdal.GDT_Byte)
    image.SetGeoTransform(place)
    image.SetProjection(system.ExportToWkt())
    image.GetRasterBand(1).WriteArray(np.where(bar, 200, np.where(row < 4, 255, 30)).astype(np.uint8))
    image.GetRasterBand(1).SetNoDataValue(255)
    image = None
    process(
        folder,
        'run',
        'quench:centrelinesofimage',
        '--',
        'INPUT=image.tif',
        'BAND=1',
        'THRESHOLD=100',
        'OUTPUT=image_lines.gpkg',
    )
    drawn = ogr.Open(f'{folder}/image_lines.gpkg')  # kept while its features are
    lines = list(drawn.GetLayer())
    assert len(lines) == 3
    for feature in lines:
        points = np.array(feature.GetGeometryRef().GetPoints())[:, :2]
        at = np.stack([(NORTH - points[:, 1]) / 0.5, (points[:, 0] - EAST) / 0.5], axis=1).astype(int)
        assert bar[tuple(at.T)].all(), 'a line leaves the bright pixels'
    process(
        folder,
        'run',
        'quench:thicknessofimage',
        '--',
        'INPUT=image.tif',
        'BAND=1',
        'THRESHOLD=100',
        'OUTPUT=thickness.tif',
    )
    found = gdal.Open(f'{folder}/thickness.tif')
    values = found.GetRasterBand(1).ReadAsArray()
    assert found.GetGeoTransform() == place and found.GetRasterBand(1).GetNoDataValue() == 0
    assert osr.SpatialReference(wkt=found.GetProjection()).GetAuthorityCode(None) == '32632'
    assert ((values > 0) == bar).all() and 8 < values.max() < 10, values.max()  # 17 pixels of 0.5
    print(f'image: 3 lines, thickness up to {values.max():.2f}, where the image is')


def main():
    if not PROCESS:
        print('there is no QGIS (Debian: qgis python3-qgis)')
        sys.exit(77)
    try:
        from osgeo import gdal, ogr, osr
    except ImportError:
        print('there is no GDAL for Python (Debian: python3-gdal)')
        sys.exit(77)
    gdal.UseExceptions()
    ogr.UseExceptions()
    folder = tempfile.mkdtemp(prefix='quench-qgis-')
    os.chmod(folder, 0o700)
    try:
        process(folder, 'plugins', 'enable', 'quench_processing')
        listed = process(folder, 'list')
        for name in ('centrelinesofpolygons', 'centrelinesofimage', 'thicknessofimage'):
            assert f'quench:{name}' in listed, listed[-2000:]
        check_polygons(folder, ogr, osr)
        check_image(folder, gdal, osr, ogr)
        try:
            process(
                folder,
                'run',
                'quench:thicknessofimage',
                '--',
                'INPUT=image.tif',
                'BAND=1',
                'THRESHOLD=251',
                'OUTPUT=none.tif',
            )
        except Failed as failed:
            assert 'quench' in str(failed) and 'Traceback' not in str(failed), failed
        else:
            raise AssertionError('an empty shape is no error')
        print('an empty shape: the sentence of the program')
        with open(f'{folder}/at_once.py', 'w', encoding='utf-8') as file:
            file.write(AT_ONCE)
        assert 'at once: good' in run_in(folder, sys.executable, '-B', 'at_once.py', HERE)
        print('two at a time in folders of their own; one that is stopped ends, and its program with it')
    finally:
        shutil.rmtree(folder)


if __name__ == '__main__':
    main()
