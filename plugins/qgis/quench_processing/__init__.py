# SPDX-License-Identifier: Apache-2.0
"""Quench in the Processing toolbox of QGIS."""


def classFactory(iface):
    from .provider import Plugin

    return Plugin()
