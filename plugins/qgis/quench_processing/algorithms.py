# SPDX-License-Identifier: Apache-2.0
"""Algorithms of the Processing toolbox that run the program quench on polygons and images."""
import json
import math
import os
import queue
import shutil
import subprocess
import tempfile
import threading

from osgeo import gdal
from qgis.core import (
    QgsFeature,
    QgsField,
    QgsFields,
    QgsGeometry,
    QgsPointXY,
    QgsProcessing,
    QgsProcessingAlgorithm,
    QgsProcessingException,
    QgsProcessingParameterBand,
    QgsProcessingParameterBoolean,
    QgsProcessingParameterDefinition,
    QgsProcessingParameterDistance,
    QgsProcessingParameterFeatureSink,
    QgsProcessingParameterFeatureSource,
    QgsProcessingParameterFile,
    QgsProcessingParameterRasterDestination,
    QgsProcessingParameterRasterLayer,
    QgsProcessingParameterString,
    QgsProcessingUtils,
    QgsWkbTypes,
)
from qgis.PyQt.QtCore import QVariant

MEASURES = [
    ('branch', QVariant.Int),
    ('length', QVariant.Double),
    ('mean_radius', QVariant.Double),
    ('min_radius', QVariant.Double),
    ('max_radius', QVariant.Double),
    ('thickness', QVariant.Double),
    ('tortuosity', QVariant.Double),
]


class Algorithm(QgsProcessingAlgorithm):
    """What all have in common: the program, how it is run."""

    def createInstance(self):
        return type(self)()

    def name(self):
        return type(self).__name__.lower()

    def group(self):
        return None

    def groupId(self):
        return None

    def add(self, *parameters):
        for parameter in parameters:
            self.addParameter(parameter)

    def add_program(self):
        program = QgsProcessingParameterFile(
            'PROGRAM', 'Program quench (found by itself where it is installed)', optional=True
        )
        program.setFlags(program.flags() | QgsProcessingParameterDefinition.FlagAdvanced)
        self.addParameter(program)

    def processAlgorithm(self, parameters, context, feedback):
        # QGIS has one folder for all that run at a time: each gets its own in it.
        with tempfile.TemporaryDirectory(prefix='quench-', dir=QgsProcessingUtils.tempFolder()) as folder:
            return self.work(parameters, context, feedback, folder)

    def run_quench(self, words, parameters, context, feedback, folder):
        """Runs the program in a folder; its lines go to the log, its errors become those of the algorithm."""
        program = (
            self.parameterAsFile(parameters, 'PROGRAM', context) or os.environ.get('QUENCH') or shutil.which('quench')
        )
        if not program:
            raise QgsProcessingException(
                'The program quench is not found; install it, or say where it is under "Advanced".'
            )
        words = [program, *words, '--overwrite']
        feedback.pushCommandInfo(' '.join(words))
        try:
            process = subprocess.Popen(words, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        except OSError as error:
            raise QgsProcessingException(f'{program} cannot be run: {error.strerror}') from error
        lines, last = queue.Queue(), ''

        def listen():  # a line may not come for long
            for line in process.stdout:
                lines.put(line)
            lines.put(None)

        listener = threading.Thread(target=listen, daemon=True)
        listener.start()
        try:
            while True:
                stop_if_cancelled(feedback)
                try:
                    line = lines.get(timeout=0.2)
                except queue.Empty:
                    continue
                if line is None:
                    break
                last = line.strip() or last
                feedback.pushInfo(line.rstrip())
        except BaseException:
            process.kill()
            raise
        finally:
            process.wait()
            listener.join()
            process.stdout.close()
        stop_if_cancelled(feedback)
        if process.returncode != 0:
            raise QgsProcessingException(last or f'{program} ended with {process.returncode}')

    def line_sink(self, parameters, context, fields, crs):
        sink, identifier = self.parameterAsSink(parameters, 'OUTPUT', context, fields, QgsWkbTypes.LineString, crs)
        if sink is None:
            raise QgsProcessingException(self.invalidSinkError(parameters, 'OUTPUT'))
        return sink, identifier


def stop_if_cancelled(feedback):
    if feedback.isCanceled():
        raise QgsProcessingException('cancelled')


def with_measures(fields):
    """The fields of the input, and behind them those of branches that have no name in common with them."""
    every = QgsFields()
    for field in fields:
        field = QgsField(field)
        if field.name().lower() == 'fid':  # several lines of a polygon: no key of a GeoPackage any more
            field.setName('polygon_fid')
        every.append(field)
    for name, kind in MEASURES:
        while every.lookupField(name) >= 0:
            name = f'quench_{name}'
        every.append(QgsField(name, kind))
    return every


def measured(properties):
    """The measures of a branch, infinite ones as nothing."""
    values = [properties.get(name) for name, _ in MEASURES]
    return [value if isinstance(value, (int, float)) and math.isfinite(value) else None for value in values]


def lines_of(file):
    """Lines of a GeoJSON file of the program, with their properties."""
    with open(file, encoding='utf-8') as opened:
        for feature in json.load(opened)['features']:
            if feature['geometry'] and feature['geometry']['type'] == 'LineString':
                yield feature['geometry']['coordinates'], feature['properties']


class CentreLinesOfPolygons(Algorithm):
    """A line per branch of the medial axis of each polygon."""

    def displayName(self):
        return 'Centre lines of polygons'

    def shortHelpString(self):
        return (
            'Lines through the middle of polygons: rivers, roads, lakes, buildings. Each line has the attributes of its polygon, '
            'its length, and half the width of the polygon along it (mean_radius, min_radius, max_radius).\n\n'
            'Polygons are taken as pixels: choose them a fifth of the narrowest width or smaller. Without a size each polygon has '
            '1024 along its longer side.\n\n'
            'Branches that stick out less than the given length are left out: 0.5r is half the radius of what they leave, 2r '
            'leaves fewer branches, 30abs are 30 units of the layer.\n\n'
            'Layers in degrees: reproject them first.'
        )

    def initAlgorithm(self, configuration=None):
        self.add(
            QgsProcessingParameterFeatureSource('INPUT', 'Polygons', [QgsProcessing.TypeVectorPolygon]),
            QgsProcessingParameterDistance('PIXEL', 'Size of a pixel', None, 'INPUT', optional=True, minValue=0),
            QgsProcessingParameterString('THETA1', 'Branches stick out by at least', '0.5r'),
            QgsProcessingParameterBoolean('LONGEST', 'Only one line through each part', False),
            QgsProcessingParameterBoolean('EXTEND', 'Draw free ends out to the outline', False),
            QgsProcessingParameterFeatureSink('OUTPUT', 'Centre lines', QgsProcessing.TypeVectorLine),
        )
        self.add_program()

    def work(self, parameters, context, feedback, folder):
        source = self.parameterAsSource(parameters, 'INPUT', context)
        if source is None:
            raise QgsProcessingException(self.invalidSourceError(parameters, 'INPUT'))
        if source.sourceCrs().isGeographic():
            feedback.pushWarning('The layer is in degrees, which are of different length east and north; reproject it.')
        rows = []
        polygons = os.path.join(folder, 'quench_polygons.geojson')
        with open(polygons, 'w', encoding='utf-8') as file:
            file.write('{"type": "FeatureCollection", "features": [')
            for feature in source.getFeatures():
                stop_if_cancelled(feedback)
                if feature.geometry().isEmpty():
                    continue
                file.write(',\n' if rows else '\n')
                file.write(
                    f'{{"type": "Feature", "properties": {{"row": {len(rows)}}}, "geometry": {feature.geometry().asJson(15)}}}'
                )
                rows.append(feature.attributes())
            file.write(']}\n')
        fields = with_measures(source.fields())
        sink, identifier = self.line_sink(parameters, context, fields, source.sourceCrs())
        if not rows:
            return {'OUTPUT': identifier}
        words = [
            'run',
            polygons,
            '--no-view',
            '--no-picture',
            '-o',
            'quench_lines',
            '--theta1',
            self.parameterAsString(parameters, 'THETA1', context),
        ]
        pixel = self.parameterAsDouble(parameters, 'PIXEL', context)
        if parameters.get('PIXEL') is not None and pixel > 0:
            words += ['--pixel', repr(pixel)]
        words += [
            f'--{name.lower()}' for name in ('LONGEST', 'EXTEND') if self.parameterAsBool(parameters, name, context)
        ]
        self.run_quench(words, parameters, context, feedback, folder)
        for points, properties in lines_of(os.path.join(folder, 'quench_lines', 'skeleton.geojson')):
            feature = QgsFeature(fields)
            feature.setGeometry(QgsGeometry.fromPolylineXY([QgsPointXY(*point[:2]) for point in points]))
            feature.setAttributes(rows[int(properties['row'])] + measured(properties))
            if not sink.addFeature(feature):
                raise QgsProcessingException(f'A line cannot be written: {sink.lastError()}')
        return {'OUTPUT': identifier}


class OfImage(Algorithm):
    """An image layer as a plain file that the program reads, and where its pixels are."""

    def add_image(self):
        self.add(
            QgsProcessingParameterRasterLayer('INPUT', 'Image'),
            QgsProcessingParameterBand('BAND', 'Band', 1, 'INPUT'),
            QgsProcessingParameterString(
                'THRESHOLD',
                'The shape: values from (or auto, otsu, thin; LOW,HIGH: from LOW on, where connected to HIGH)',
                'auto',
            ),
            QgsProcessingParameterBoolean('INVERT', 'The rest instead: what is dark', False),
        )

    def written(self, parameters, context, folder):
        """The words for the program and the geotransform; pixels without data are not the shape."""
        layer = self.parameterAsRasterLayer(parameters, 'INPUT', context)
        if layer is None:
            raise QgsProcessingException(self.invalidRasterError(parameters, 'INPUT'))
        image = gdal.Open(layer.source())
        if image is None:
            raise QgsProcessingException('Only layers of files can be used; save this one as GeoTIFF first.')
        band = image.GetRasterBand(self.parameterAsInt(parameters, 'BAND', context))
        values = band.ReadAsArray()
        nothing = band.GetNoDataValue()
        invert = self.parameterAsBool(parameters, 'INVERT', context)
        if nothing is not None:
            missing = (values != values) if nothing != nothing else values == nothing
            if missing.any() and not missing.all():
                values[missing] = values[~missing].max() if invert else values[~missing].min()
        file = os.path.join(folder, 'quench_image.tif')
        copy = gdal.GetDriverByName('GTiff').Create(file, image.RasterXSize, image.RasterYSize, 1, band.DataType)
        copy.GetRasterBand(1).WriteArray(values)
        copy = None  # closed
        place = image.GetGeoTransform()
        spacing = (math.hypot(place[1], place[4]), math.hypot(place[2], place[5]))
        words = [
            file,
            '--threshold',
            self.parameterAsString(parameters, 'THRESHOLD', context),
            '--spacing',
            f'{spacing[0]!r},{spacing[1]!r}',
        ]
        return words + (['--invert'] if invert else []), image, place, spacing, layer.crs()


class CentreLinesOfImage(OfImage):
    """A line per branch of the medial axis of what is bright in an image."""

    def displayName(self):
        return 'Centre lines of an image'

    def shortHelpString(self):
        return (
            'Lines through the middle of what is bright (or dark) in a raster: water masks, cracks, roads. Each line has its length '
            'and half the width along it.\n\nBranches that stick out less than the given length are left out: 0.5r is half the '
            'radius of what they leave, 10vox ten pixels.'
        )

    def initAlgorithm(self, configuration=None):
        self.add_image()
        self.add(
            QgsProcessingParameterString('THETA1', 'Branches stick out by at least', '0.5r'),
            QgsProcessingParameterFeatureSink('OUTPUT', 'Centre lines', QgsProcessing.TypeVectorLine),
        )
        self.add_program()

    def work(self, parameters, context, feedback, folder):
        words, _, place, spacing, crs = self.written(parameters, context, folder)
        fields = with_measures(QgsFields())
        sink, identifier = self.line_sink(parameters, context, fields, crs)
        theta1 = self.parameterAsString(parameters, 'THETA1', context)
        self.run_quench(
            ['run', *words, '--theta1', theta1, '--no-view', '--no-picture', '-o', 'quench_image_lines'],
            parameters,
            context,
            feedback,
            folder,
        )
        for points, properties in lines_of(os.path.join(folder, 'quench_image_lines', 'skeleton.geojson')):
            feature = QgsFeature(fields)
            pixels = [
                (x / spacing[0] + 0.5, y / spacing[1] + 0.5) for x, y, *_ in points
            ]  # the centre of the first: 0.5, 0.5
            feature.setGeometry(
                QgsGeometry.fromPolylineXY(
                    [
                        QgsPointXY(place[0] + x * place[1] + y * place[2], place[3] + x * place[4] + y * place[5])
                        for x, y in pixels
                    ]
                )
            )
            feature.setAttributes(measured(properties))
            if not sink.addFeature(feature):
                raise QgsProcessingException(f'A line cannot be written: {sink.lastError()}')
        return {'OUTPUT': identifier}


class ThicknessOfImage(OfImage):
    """Local thickness of what is bright in an image."""

    def displayName(self):
        return 'Local thickness of an image'

    def shortHelpString(self):
        return (
            'How wide is it? At every pixel of what is bright (or dark) the diameter of the largest circle inside that contains '
            'it, in units of the layer; no data elsewhere.'
        )

    def initAlgorithm(self, configuration=None):
        self.add_image()
        self.add(QgsProcessingParameterRasterDestination('OUTPUT', 'Thickness'))
        self.add_program()

    def work(self, parameters, context, feedback, folder):
        words, image, place, _, crs = self.written(parameters, context, folder)
        output = self.parameterAsOutputLayer(parameters, 'OUTPUT', context)
        self.run_quench(['thickness', *words, '-o', 'quench_thickness.tif'], parameters, context, feedback, folder)
        found = gdal.Open(os.path.join(folder, 'quench_thickness.tif'))
        written = gdal.GetDriverByName('GTiff').Create(
            output, image.RasterXSize, image.RasterYSize, 1, gdal.GDT_Float32, ['COMPRESS=DEFLATE']
        )
        written.SetGeoTransform(place)
        written.SetProjection(crs.toWkt() or image.GetProjection())
        written.GetRasterBand(1).WriteArray(found.GetRasterBand(1).ReadAsArray())
        written.GetRasterBand(1).SetNoDataValue(0)
        written = found = None  # closed
        return {'OUTPUT': output}
