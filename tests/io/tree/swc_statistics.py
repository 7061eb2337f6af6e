# SPDX-License-Identifier: Apache-2.0
"""Statistics of an SWC file with a soma of one sample, by the definitions of NeuroM (docs of neurom.features), from the
samples alone.

swc_statistics.py FILE    a line `sample NAME VALUE` per statistic, then a line `section` per section: the place of its
                          end, its length with the segment from the soma (NeuroM leaves that out), that segment, Strahler
                          order, branch order, tips behind it, radius at its end

A section runs between the soma, bifurcations and terminations.
"""
import collections
import math
import statistics
import sys


def angle(a, b, c):
    """At b, in degrees."""
    u, v = ([p - q for p, q in zip(x, b)] for x in (a, c))
    cosine = sum(p * q for p, q in zip(u, v)) / math.hypot(*u) / math.hypot(*v)
    return math.degrees(math.acos(max(-1, min(1, cosine))))


def main():
    rows = {}
    with open(sys.argv[1], encoding='utf-8') as file:
        for line in file:
            words = line.split()
            if words and not words[0].startswith('#'):
                rows[int(words[0])] = (int(words[1]), tuple(map(float, words[2:5])), float(words[5]), int(words[6]))
    soma = [i for i, row in rows.items() if row[0] == 1]
    assert len(soma) == 1 and rows[soma[0]][3] == -1
    soma = soma[0]
    children = collections.defaultdict(list)
    for i, row in rows.items():
        children[row[3]].append(i)

    def step(i):
        return math.dist(rows[i][1], rows[rows[i][3]][1])

    sections = []  # [samples, parent section]
    open_ = [(i, None) for i in children[soma]]
    while open_:
        first, parent = open_.pop()
        samples = [first]
        while len(children[samples[-1]]) == 1:
            samples += children[samples[-1]]
        sections.append((samples, parent))
        open_ += [(i, len(sections) - 1) for i in children[samples[-1]]]
    below = collections.defaultdict(list)
    for s, (_, parent) in enumerate(sections):
        below[parent].append(s)
    strahler, tips, order = {}, {}, {}
    for s in range(len(sections)):
        order[s] = 0 if sections[s][1] is None else order[sections[s][1]] + 1
    for s in reversed(range(len(sections))):
        of_children = sorted((strahler[c] for c in below[s]), reverse=True)
        strahler[s] = 1 if not of_children else of_children[0] + (of_children[:2].count(of_children[0]) == 2)
        tips[s] = 1 if not below[s] else sum(tips[c] for c in below[s])

    links = sum(step(i) for i in children[soma])
    whole = sum(step(i) for i in rows if i != soma)
    forks = [s for s in range(len(sections)) if len(below[s]) == 2]
    asymmetry, local, remote = [], [], []
    for s in forks:
        a, b = below[s]
        n, m = tips[a], tips[b]
        asymmetry.append(0 if n == m else abs(n - m) / (n + m - 2))
        at = rows[sections[s][0][-1]][1]
        local.append(angle(rows[sections[a][0][0]][1], at, rows[sections[b][0][0]][1]))
        remote.append(angle(rows[sections[a][0][-1]][1], at, rows[sections[b][0][-1]][1]))
    facts = {'neurites': len(children[soma]), 'branches': len(sections), 'forks': sum(bool(below[s]) for s in range(len(sections))),
             'tips': sum(not below[s] for s in range(len(sections))), 'total_length': whole, 'total_length_without_soma': whole - links,
             'strahler': max(strahler.values()), 'max_order': max(order.values()), 'soma_radius': rows[soma][2],
             'partition_asymmetry': statistics.fmean(asymmetry), 'local_angle': statistics.fmean(local),
             'remote_angle': statistics.fmean(remote)}
    for name, value in facts.items():
        print('sample', name, repr(value))
    for s, (samples, parent) in enumerate(sections):
        link = step(samples[0]) if parent is None else 0.0
        print('section', *map(repr, rows[samples[-1]][1]), repr(sum(map(step, samples))), repr(link), strahler[s], order[s], tips[s],
              repr(rows[samples[-1]][2]))


if __name__ == '__main__':
    main()
