import unittest

import support  # noqa: F401  (makes the tools importable)
import numpy as np

from slam_tools.spherical import position_and_covariance


def position(reading):
    return position_and_covariance(*reading, 0.0, 0.0, 0.0)[0]


class Spherical(unittest.TestCase):
    def test_axes_are_forward_left_and_up(self):
        np.testing.assert_allclose(position((2.0, 0.0, 0.0)), [2.0, 0.0, 0.0], atol=1e-15)
        np.testing.assert_allclose(position((2.0, 0.5 * np.pi, 0.0)), [0.0, 2.0, 0.0], atol=1e-15)
        np.testing.assert_allclose(position((2.0, 0.0, 0.5 * np.pi)), [0.0, 0.0, 2.0], atol=1e-15)

    def test_covariance_is_that_of_sampled_readings(self):
        rng = np.random.default_rng(3)
        sigmas = np.array([0.03, 0.02, 0.01])
        for reading in [(3.0, 0.0, 0.0), (2.0, 2.5, 0.6), (4.0, -1.0, -1.1), (1.0, np.pi, 0.2)]:
            _, covariance = position_and_covariance(*reading, *sigmas)
            samples = np.array([position(reading + sigmas * rng.normal(size=3)) for _ in range(20000)])
            np.testing.assert_allclose(np.cov(samples.T), covariance, atol=0.05 * np.trace(covariance))

    def test_covariance_has_the_readings_sigmas_along_and_across_the_ray(self):
        _, covariance = position_and_covariance(5.0, 0.7, -0.4, 0.1, 0.02, 0.04)
        np.testing.assert_allclose(np.sqrt(np.linalg.eigvalsh(covariance)), [5.0 * np.cos(0.4) * 0.02, 0.1, 0.2])


if __name__ == "__main__":
    unittest.main()
