# SPDX-License-Identifier: Apache-2.0
"""Quench in napari: a reader of its results, and widgets; napari.yaml is the manifest."""
