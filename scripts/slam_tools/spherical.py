"""Readings in range, bearing and elevation as the position and covariance that a LandmarkDetection carries."""
import numpy as np


def position_and_covariance(distance, bearing, elevation, sigma_distance, sigma_bearing, sigma_elevation):
    """(position in m, covariance in m^2) in the sensor's frame: x forward, y left, z up.

    distance in m; bearing to the left and elevation upwards in rad, as turns about z and then about -y. The
    covariance holds to first order in the errors of the angles. MRPT's CObservationBearingRange counts its pitch downwards:
    elevation = -pitch.
    """
    cos_b, sin_b = np.cos(bearing), np.sin(bearing)
    cos_e, sin_e = np.cos(elevation), np.sin(elevation)
    ray = np.array([cos_e * cos_b, cos_e * sin_b, sin_e])
    by_bearing = distance * cos_e * np.array([-sin_b, cos_b, 0.0])
    by_elevation = distance * np.array([-sin_e * cos_b, -sin_e * sin_b, cos_e])
    jacobian = np.column_stack([ray, by_bearing, by_elevation])
    variances = np.square([sigma_distance, sigma_bearing, sigma_elevation])
    return distance * ray, jacobian @ np.diag(variances) @ jacobian.T
