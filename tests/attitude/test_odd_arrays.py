"""Arrays that are no quaternions, vectors or rotations are refused by name."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt.attitude import errors, euler, mrp, quaternion
from jaxatt.attitude.components import Matrix, Quaternion, Vector
from jaxatt.attitude.vectors import cross, skew

Q, V, M = np.array([0.6, 0.0, 0.8, 0.0]), np.array([1.0, 2.0, 3.0]), np.eye(3)
FUNCTIONS = {
    quaternion.multiply: (Q, Q),
    quaternion.conjugate: (Q,),
    quaternion.normalize: (Q,),
    quaternion.canonical: (Q,),
    quaternion.to_matrix: (Q,),
    quaternion.from_matrix: (M,),
    quaternion.rotate: (Q, V),
    quaternion.rotate_inverse: (Q, V),
    quaternion.derivative: (Q, V),
    functools.partial(quaternion.slerp, fraction=0.5): (Q, Q),
    quaternion.from_rotation_vector: (V,),
    quaternion.to_rotation_vector: (Q,),
    functools.partial(quaternion.from_axis_angle, angle=1.0): (V,),
    euler.to_matrix: (V,),
    euler.to_quaternion: (V,),
    euler.from_matrix: (M,),
    euler.from_quaternion: (Q,),
    mrp.from_quaternion: (Q,),
    functools.partial(mrp.from_quaternion, short=False): (Q,),
    mrp.to_quaternion: (V,),
    mrp.shadow: (V,),
    mrp.switch: (V,),
    mrp.to_matrix: (V,),
    mrp.multiply: (V, V),
    mrp.derivative: (V, V),
    errors.error_quaternion: (Q, Q),
    errors.angle: (Q, Q),
    errors.rotation_vector: (Q, Q),
    errors.pseudo_metric: (Q, Q),
    errors.smooth_pseudo_metric: (Q, Q),
    cross: (V, V),
    skew: (V,),
    Quaternion.of: (Q,),
    Vector.of: (V,),
    Matrix.of: (M,),
}


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda f: getattr(f, "__qualname__", "partial"))
def test_wrong_shapes_are_named(function):
    right = FUNCTIONS[function]
    function(*right)
    for place, array in enumerate(right):
        wrong = [array[..., :-1], np.concatenate([array, array], axis=-1), array[..., :1], 1.0]
        for odd in wrong:
            arguments = [odd if at == place else given for at, given in enumerate(right)]
            with pytest.raises(ValueError, match=r"has shape .*; give an array of shape \(\.\.\."):
                function(*arguments)


@pytest.mark.parametrize("from_matrix", [quaternion.from_matrix, euler.from_matrix])
def test_reflections_are_no_attitudes(from_matrix):
    rng = np.random.default_rng(10)
    rotations = quaternion.to_matrix(quaternion.normalize(rng.normal(size=(20, 4))))
    mirrors = np.asarray(rotations) @ np.diag([1.0, -1.0, 1.0])
    compiled = jax.jit(from_matrix)
    np.testing.assert_allclose(compiled(rotations), from_matrix(rotations), atol=1e-14)
    assert np.isnan(np.asarray(compiled(mirrors))).all()
    for mirror in mirrors:
        with pytest.raises(ValueError, match="it is a reflection, which no attitude is; check"):
            from_matrix(mirror)
    with pytest.raises(ValueError, match="reflection"):
        from_matrix(jnp.concatenate([rotations, mirrors[:1]]))


@pytest.mark.parametrize("from_matrix", [quaternion.from_matrix, euler.from_matrix])
def test_matrices_far_from_a_rotation_are_refused_and_rounded_ones_taken(from_matrix):
    rng = np.random.default_rng(11)
    rotations = np.asarray(quaternion.to_matrix(quaternion.normalize(rng.normal(size=(50, 4)))))
    rounded = from_matrix(np.round(rotations, 2))
    np.testing.assert_allclose(rounded, from_matrix(rotations), atol=0.1)
    for odd in (2.0 * M, np.zeros((3, 3)), np.full((3, 3), np.nan), np.diag([1.0, 1.0, 1.1])):
        with pytest.raises(ValueError, match="not three orthogonal unit vectors"):
            from_matrix(odd)
