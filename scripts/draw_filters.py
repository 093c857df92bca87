#!/usr/bin/python3
"""Draws the pictures of docs/filters.md: docs/images/filters_*.png.

  scripts/draw_filters.py [FOLDER]     default: docs/images

The Kalman filter is that of estimators/gaussian.h with the report's worked figures; the particles see landmarks as
those of estimators/particle_localization.h do. Fixed seeds: the same pictures every time.
"""
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
if __name__ == "__main__":
    from slam_tools.environment import use_system_python
    use_system_python()

import matplotlib   # noqa: E402

matplotlib.use("Agg")

import matplotlib.pyplot as plt   # noqa: E402
import numpy as np   # noqa: E402

from slam_tools.plots import ESTIMATE_COLOR, LANDMARK_COLOR, STYLE, TRUTH_COLOR   # noqa: E402

ROOT = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
PRIOR_COLOR, MEASUREMENT_COLOR = "#e69f00", "#009e73"


def density(x, mean, variance):
    return np.exp(-0.5 * (x - mean) ** 2 / variance) / np.sqrt(2.0 * np.pi * variance)


def predict(mean, variance, move, move_variance):
    return mean + move, variance + move_variance


def correct(mean, variance, measurement, measurement_variance):
    gain = variance / (variance + measurement_variance)
    return mean + gain * (measurement - mean), (1.0 - gain) * variance


def draw_gaussians(figure):
    line, plane_a, plane_b = figure.subplots(1, 3)
    x = np.linspace(-6.0, 10.0, 500)
    for mean, sigma, color in ((0.0, 1.0, ESTIMATE_COLOR), (2.0, 2.0, PRIOR_COLOR), (3.0, np.sqrt(20.0), LANDMARK_COLOR)):
        line.plot(x, density(x, mean, sigma ** 2), color=color, label=f"mean {mean:g}, variance {sigma ** 2:g}")
    line.set_title("(a) On a line")
    line.set_xlabel("x")
    line.set_ylabel("density")
    line.set_ylim(0.0, 0.6)
    line.legend(loc="upper right")
    grid = np.stack(np.meshgrid(np.linspace(-4.0, 10.0, 300), np.linspace(-5.0, 9.0, 300)), axis=-1)
    for axes, covariance, title in ((plane_a, [[4.0, 1.0], [1.0, 5.0]], "(b) The report's: [[4, 1], [1, 5]]"),
                                    (plane_b, [[9.0, 0.0], [0.0, 0.5]], "(c) Wide along x: [[9, 0], [0, 0.5]]")):
        offset = grid - np.array([3.0, 2.0])
        squared = np.einsum("...i,ij,...j->...", offset, np.linalg.inv(covariance), offset)
        axes.contourf(grid[..., 0], grid[..., 1], np.exp(-0.5 * squared), levels=12, cmap="Blues")
        axes.contour(grid[..., 0], grid[..., 1], squared, levels=[1.0, 4.0, 9.0], colors=TRUTH_COLOR, linewidths=0.7)
        axes.set_title(title)
        axes.set_xlabel("x")
        axes.set_aspect("equal")
    plane_a.set_ylabel("y")


def draw_steps(axes, start, move_variance, measurement_variance, title):
    """Three rounds of a robot that moves by one and measures its place."""
    x = np.linspace(-4.0, 12.0, 600)
    mean, variance = start
    axes.plot(x, density(x, mean, variance) + 3.0, color=TRUTH_COLOR, linewidth=1.0)
    for i, measurement in enumerate((3.4, 3.8, 5.3)):
        base = 2.0 - i
        mean, variance = predict(mean, variance, 1.0, move_variance)
        axes.plot(x, density(x, mean, variance) + base, color=PRIOR_COLOR, label="after the motion")
        axes.plot(x, density(x, measurement, measurement_variance) + base, color=MEASUREMENT_COLOR, linestyle=":",
                  label="measurement")
        mean, variance = correct(mean, variance, measurement, measurement_variance)
        axes.fill_between(x, base, density(x, mean, variance) + base, color=ESTIMATE_COLOR, alpha=0.35, linewidth=0,
                          label="after the measurement")
        axes.text(11.8, base + 0.12, f"σ {np.sqrt(variance):.2f}", ha="right", color=ESTIMATE_COLOR)
    axes.set_yticks([3.0, 2.0, 1.0, 0.0], ["start", "1", "2", "3"])
    axes.set_title(title)
    axes.set_xlabel("place (m)")


def draw_noises(figure):
    panels = figure.subplots(1, 3, sharey=True)
    draw_steps(panels[0], (2.0, 4.0), 1.0, 1.0, "(a) Motion σ 1, measurement σ 1")
    draw_steps(panels[1], (2.0, 4.0), 16.0, 1.0, "(b) Motion σ 4 (the report's)")
    draw_steps(panels[2], (2.0, 4.0), 1.0, 9.0, "(c) Measurement σ 3")
    panels[0].set_ylabel("round")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles[:3], labels[:3], loc="lower center", ncol=3)


def resample(particles, weights, random):
    pointers = (np.arange(len(weights)) + random.uniform()) / len(weights)
    return particles[np.searchsorted(np.cumsum(weights), pointers)]


def draw_particles(figure):
    """A robot that does not know where it is among four landmarks that look alike, and drives."""
    random = np.random.default_rng(3)
    landmarks = np.array([[1.0, 0.8], [4.6, 1.2], [4.1, 4.0], [0.4, 2.6]])
    pose = np.array([2.0, 1.2, 0.4])
    sigma = 0.1
    particles = []
    steps = {0: "(a) The first sighting", 6: "(b) After 0.6 m", 14: "(c) After 1.4 m", 36: "(d) After 3.6 m"}
    panels = dict(zip(steps, figure.subplots(1, 4, sharey=True)))

    def in_base(poses, points):
        offset = points[:, None, :] - poses[None, :, :2]
        c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
        return np.stack([c * offset[..., 0] + s * offset[..., 1], c * offset[..., 1] - s * offset[..., 0]], axis=-1)

    for step in range(37):
        truth = in_base(pose[None, :], landmarks)[:, 0]
        ahead = (truth[:, 0] > 0.2) & (np.abs(truth[:, 1]) < truth[:, 0]) & (np.hypot(*truth.T) < 3.0)
        seen = truth[ahead] + sigma * random.standard_normal((ahead.sum(), 2))
        if len(particles) == 0 and len(seen):
            headings = np.linspace(-np.pi, np.pi, 400, endpoint=False)
            c, s = np.cos(headings), np.sin(headings)
            turned = np.stack([c * seen[0, 0] - s * seen[0, 1], s * seen[0, 0] + c * seen[0, 1]], axis=-1)
            particles = np.concatenate([np.column_stack([point - turned, headings]) for point in landmarks])
        elif len(seen):
            expected = in_base(particles, landmarks)
            log_weights = np.zeros(len(particles))
            for z in seen:
                squared = np.min(np.sum((expected - z) ** 2, axis=-1), axis=0) / sigma ** 2
                log_weights += np.log(np.exp(-0.5 * squared) + 1e-4)
            weights = np.exp(log_weights - log_weights.max())
            particles = resample(particles, weights / weights.sum(), random)
        if step in panels:
            axes = panels[step]
            axes.quiver(*particles[:, :2].T, np.cos(particles[:, 2]), np.sin(particles[:, 2]), color=ESTIMATE_COLOR,
                        alpha=0.35, scale=28, width=0.004)
            axes.plot(*landmarks.T, linestyle="none", marker="o", color=LANDMARK_COLOR, label="landmark")
            axes.quiver(*pose[:2], np.cos(pose[2]), np.sin(pose[2]), color=TRUTH_COLOR, scale=9, width=0.014)
            axes.set_title(steps[step])
            axes.set_aspect("equal")
            axes.set_xlim(-2.2, 7.4)
            axes.set_ylim(-2.4, 7.0)
            axes.set_xlabel("x (m)")
        move = np.array([0.1, 0.09])
        pose = pose + np.array([move[0] * np.cos(pose[2]), move[0] * np.sin(pose[2]), move[1]])
        noisy = move + np.array([0.02, 0.02]) * random.standard_normal((len(particles), 2))
        particles = particles + np.column_stack([noisy[:, 0] * np.cos(particles[:, 2]),
                                                 noisy[:, 0] * np.sin(particles[:, 2]), noisy[:, 1]])
    panels[0].set_ylabel("y (m)")


def main():
    folder = sys.argv[1] if len(sys.argv) > 1 else os.path.join(ROOT, "docs", "images")
    os.makedirs(folder, exist_ok=True)
    for name, draw, size in (("gaussians", draw_gaussians, (11.0, 3.5)), ("noise", draw_noises, (11.0, 4.6)),
                             ("particles", draw_particles, (13.0, 3.6))):
        with plt.rc_context(STYLE):
            figure = plt.figure(figsize=size, dpi=100)
            draw(figure)
            figure.tight_layout(rect=(0.0, 0.07 if name == "noise" else 0.0, 1.0, 1.0))
            figure.savefig(os.path.join(folder, f"filters_{name}.png"))
            plt.close(figure)


if __name__ == "__main__":
    main()
