# SPDX-License-Identifier: Apache-2.0
"""Axes of few vertices, and smoothed ones."""
import unittest

import numpy as np

import quench


class Simplification(unittest.TestCase):
    def setUp(self):
        image = np.zeros((44, 34, 20), bool)
        image[2:-2, 2:-2, 2:-2] = True
        image[18:26, 12:22] = False
        self.axis = quench.medial_axis(image)

    def test_levels(self):
        few = self.axis.simplified(40)
        self.assertEqual(len(few.axis.vertices), 40)
        self.assertEqual(few.axis.topology, self.axis.topology)
        self.assertEqual(few.boundary, 'voxels')
        self.assertLess(few.errors['either_side']['mean'], 1)
        self.assertGreaterEqual(few.most, len(self.axis.vertices))
        for vertices in (few.least, 20, 60):
            level = few.level(vertices, threads=1)
            self.assertEqual(len(level.vertices), vertices)
            self.assertEqual(level.topology, self.axis.topology)
        np.testing.assert_allclose(few.level(40).vertices, few.axis.vertices, rtol=1e-12)
        self.assertIn('40 of', repr(few))

    def test_error(self):
        few = self.axis.simplified(error='3abs')
        self.assertLessEqual(few.errors['either_side']['largest'], 3)
        with self.assertRaises(quench.UsageError) as caught:
            self.axis.simplified(error='1e-9abs')
        self.assertEqual(caught.exception.argument, 'error')
        with self.assertRaises(quench.UsageError):
            self.axis.simplified(0)

    def test_smoothed(self):
        smooth = self.axis.smoothed()
        move = np.linalg.norm(smooth.vertices - self.axis.vertices, axis=1)
        self.assertLessEqual(move.max(), 0.5 + 1e-12)
        self.assertEqual(smooth.topology, self.axis.topology)
        np.testing.assert_array_equal(self.axis.smoothed('0abs').vertices, self.axis.vertices)


if __name__ == '__main__':
    unittest.main()
