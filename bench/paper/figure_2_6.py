#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Fig. 2.6: the steps from a mesh to its pruned core: mesh, voxels, voxel core coloured by lambda, the lambda-subset with the
topology kept. The armadillo in the place of the hand."""
import json

import numpy as np
from paper import Complex, Scene, colours, main, read_nrrd, sheet, table, voxel_faces


def make(paper):
    mesh = paper.real('meshes/armadillo.off')
    if mesh is None:
        return
    resolution, threshold = 128, 0.025
    view = (-0.6, -0.25, 1.5)
    volume = paper.file('armadillo.nrrd')
    paper.quench('voxelize', mesh, '--resolution', resolution, '-o', volume)
    samples, spacing, origin = read_nrrd(volume)
    h = spacing[0]
    voxels = voxel_faces(samples > 0, h, origin / h - 0.5)
    full, pruned, report = paper.file('hand_full.vtp'), paper.file('hand_pruned.vtp'), paper.file('hand.json')
    paper.quench('core', mesh, '--resolution', resolution, '--surface', 'voxels', '--lambda', 0, '-o', full)
    cost = paper.quench('core', mesh, '--resolution', resolution, '--surface', 'voxels', '--lambda', threshold, '-o', pruned,
                        '--json', report)
    said = json.loads(report.read_text())
    core, left = Complex(full), Complex(pruned)
    surface = paper.surface(mesh)
    bounds = voxels.GetBounds()
    top = np.quantile(core.faces['lambda'], 0.999)
    # The front of the core is left out: it is hidden behind what the voxels' steps leave.
    middle = core.least(core.points @ np.array(view))
    behind = middle > np.median(core.points @ np.array(view))
    pictures = [Scene(view, (0, 1, 0)).add(surface, (0.75, 0.72, 0.66), smooth=True),
                Scene(view, (0, 1, 0)).add(voxels, (0.75, 0.72, 0.66)),
                Scene(view, (0, 1, 0)).add(core.sheets(behind), cells=colours(core.faces['lambda'][behind], 0, top)),
                Scene(view, (0, 1, 0)).add(surface, (0.8, 0.8, 0.8), 0.12).add(
                    left.sheets(), cells=colours(left.faces['lambda'], 0, top)).add(left.curves(left.only_curves()), (0.1, 0.1, 0.5), width=4)]
    table(('', 'voxels', 'boundary vertices', 'faces of the core', 'faces left', 'shape b0, b1, b2', 'core', 'pruned', 'CPU s'),
          [(f'armadillo at {resolution}, lambda {threshold}', said['shape']['voxels'], said['shape']['sites'], core.count,
            left.count, tuple(said['shape']['betti']), tuple(said['core']['betti']), left.betti(), f'{cost.cpu:.2f}')])
    paper.save(sheet([[p.render((560, 600), bounds) for p in pictures]],
                     ['(a) mesh', f'(b) voxels, {resolution}', '(c) rear half of the core, by λ', f'(d) pruned, λ = {threshold}'],
                     width=3.1), '2_6')


if __name__ == '__main__':
    main(make, __doc__)
