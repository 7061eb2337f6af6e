# SPDX-License-Identifier: Apache-2.0
"""The provider 'quench' of the Processing toolbox."""
from qgis.core import QgsApplication, QgsProcessingProvider

from .algorithms import CentreLinesOfImage, CentreLinesOfPolygons, ThicknessOfImage


class Provider(QgsProcessingProvider):
    """What Quench does for maps."""

    def id(self):
        return 'quench'

    def name(self):
        return 'Quench'

    def loadAlgorithms(self):
        for algorithm in (CentreLinesOfPolygons, CentreLinesOfImage, ThicknessOfImage):
            self.addAlgorithm(algorithm())


class Plugin:
    """Adds the provider, in the window and in qgis_process."""

    def __init__(self):
        self.provider = None

    def initProcessing(self):
        self.provider = Provider()
        QgsApplication.processingRegistry().addProvider(self.provider)

    def initGui(self):
        self.initProcessing()

    def unload(self):
        QgsApplication.processingRegistry().removeProvider(self.provider)
