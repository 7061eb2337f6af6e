# SPDX-License-Identifier: Apache-2.0
"""What a notebook shows: tables with pictures, and the page in a frame."""
import base64
import html.parser
import re

import numpy as np
import pytest
import quench
from shapes import bent_tube, blobs, plate_with_tunnel


class Checked(html.parser.HTMLParser):
    """Tags that are closed, attributes, texts."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.texts = [], [], []
        self.feed(text)
        self.close()
        assert not self.open, self.open

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag != 'img':
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(data)


def shown(result):
    page = Checked(result._repr_html_())
    assert all(name in ('div', 'strong', 'img', 'table', 'thead', 'tbody', 'tr', 'td', 'th', 'p', 'b') for name, _ in page.tags)
    pictures = [attributes['src'] for tag, attributes in page.tags if tag == 'img']
    for source in pictures:
        kind, data = source.split(',', 1)
        assert kind == 'data:image/png;base64' and base64.b64decode(data).startswith(b'\x89PNG\r\n')
    return ' '.join(page.texts), len(pictures)


def test_results_show_topology_ranges_units_and_a_picture():
    axis = quench.medial_axis(quench.Volume(plate_with_tunnel(), 0.5, units='mm'))
    text, pictures = shown(axis)
    assert '1 component, 1 tunnel, 0 cavities' in text and pictures == 1
    assert f'{axis.radius.min():.4g} to {axis.radius.max():.4g} mm' in text
    assert f'{len(axis.vertices):,} vertices' in text and 'θ1' not in text
    skeleton = axis.skeleton()
    text, pictures = shown(skeleton)
    assert '1 component, 1 tunnel, 0 cavities' in text and 'θ2' in text and pictures == 1
    assert f'branches {len(skeleton.branches()["length"])}' in text
    text, pictures = shown(quench.tree(quench.Volume(bent_tube(), 0.5, units='mm')))
    assert pictures == 1 and 'by level' in text and ' mm' in text
    image = quench.medial_axis(bent_tube().any(axis=2))
    text, pictures = shown(image)
    assert '1 component, 0 holes' in text and 'cavit' not in text and pictures == 1
    assert shown(image.skeleton())[1] == 1
    for result in (skeleton.graph(), skeleton.parts(), axis.solid(), image.solid(), axis.verify(samples=200),
                   quench.Volume(blobs(3)), quench.skeletonize(bent_tube())[1]):
        assert shown(result)[0]
    assert shown(axis.simplified(20))[1] == 1


def test_a_look_burns_nothing():
    axis = quench.medial_axis(blobs(21))
    shown(axis)
    heard = []
    axis.burn_time(progress=lambda stage, fraction: heard.append(stage))
    assert 'burn' in heard  # it was not burned before


def test_texts_are_escaped():
    axis = quench.medial_axis(quench.Volume(bent_tube(), units='<b onclick="x">&amp;'))
    for result in (axis, axis.skeleton(), quench.tree(axis), quench.Volume(bent_tube(), units='<script>')):
        source = result._repr_html_()
        assert '<b onclick' not in source and '<script' not in source
        assert any(units in shown(result)[0] for units in ('<b onclick="x">&amp;', '<script>'))


def test_small_and_odd_results_are_shown():
    point = quench.medial_axis(np.ones((1, 1, 1), bool))
    assert '1 vertex, 0 edges, 0 polygons' in shown(point)[0]
    shown(point.skeleton())
    shown(quench.medial_axis(np.ones((3, 3), bool)))
    assert '2 components' in shown(quench.medial_axis(np.array([[1, 0, 1]], bool)))[0]


@pytest.mark.skipif(not quench._core.has_pages, reason='this build has no interactive page')
def test_views_are_the_page_in_a_frame(tmp_path):
    axis = quench.medial_axis(bent_tube())
    results = [axis, axis.skeleton(), quench.tree(axis), quench.skeletonize(bent_tube())[1],
               quench.medial_axis(bent_tube().any(axis=2)).skeleton()]
    for result in results:
        view = result.view(height=480)
        frame, = Checked(view._repr_html_()).tags
        assert frame[0] == 'iframe' and '480px' in frame[1]['style']
        assert frame[1]['srcdoc'] == view.html and frame[1]['sandbox'] == 'allow-scripts allow-downloads'
        view.save(tmp_path / 'view.html')
        assert (tmp_path / 'view.html').read_text(encoding='utf-8') == view.html
        title = re.search('<title>(.*?)</title>', view.html)
        result.save(tmp_path / 'page.html')
        page = (tmp_path / 'page.html').read_text(encoding='utf-8')
        assert abs(len(page) - len(view.html)) < 200 and title, (len(page), len(view.html))
        assert repr(view).startswith('<quench.View')
    with pytest.raises(ValueError, match='height'):
        axis.view(height=5)


@pytest.mark.skipif(quench._core.has_pages, reason='this build has the interactive page')
def test_views_say_what_is_missing():
    with pytest.raises(quench.Error, match='page'):
        quench.medial_axis(bent_tube()).view()
