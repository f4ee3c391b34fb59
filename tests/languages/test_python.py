"""test_python.py: the package delassus: arrays in and out, errors, layouts, motion, threads."""

import contextlib
import copy
import gc
import io
import json
import os
import pickle
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import unittest.mock

import numpy as np
import scipy.io
import scipy.sparse as sp
import scipy.sparse.linalg

import delassus
from delassus import _library


def skip(what):
    """Tells what does not run because this machine lacks a tool; an error if NO_SKIP is set."""
    print("skipped:", what)
    if os.environ.get("NO_SKIP"):
        raise AssertionError("skipped where nothing may be: " + what)


POINT = np.array([[3.0, 1.0], [1.0, 2.0]]), np.array([[0.0], [1.0]]), np.array([[1.0], [0.0]])


def coupled(d, nc, seed=2, skew=0.0):
    """Returns W, q of candidates that all couple, W positive definite."""
    random = np.random.default_rng(seed)
    A = random.standard_normal((d * nc, d * nc))
    return A @ A.T + skew * np.triu(A), random.standard_normal((nc, d))


def chain(n):
    """Returns a sparse K of n unknowns, HN and HT for a contact at every fourth pair of them."""
    K = sp.diags([2.1 * np.ones(n), -np.ones(n - 1), -np.ones(n - 1)], [0, 1, -1], format="csc")
    nodes = np.arange(0, n - 1, 4)
    one = np.ones(len(nodes))
    shape = (n, len(nodes))
    return (K, sp.csc_matrix((one, (nodes + 1, np.arange(len(nodes)))), shape),
            sp.csc_matrix((one, (nodes, np.arange(len(nodes)))), shape))


class Solve(unittest.TestCase):
    def test_closed_form(self):
        s = delassus.solve(np.diag([1e-3, 1e-3]), [-2e-3, 3e-3], [0.5])  # examples/hello_contact.c
        np.testing.assert_allclose(s.r, [[2, -1]], rtol=1e-8)
        np.testing.assert_allclose(s.u, [[0, 2e-3]], atol=1e-11)
        self.assertTrue(s.solved)
        self.assertEqual((s.words, list(s.states), s.status), ("solved", ["slip"], delassus.DLS_OK))
        self.assertLessEqual(s.residual, 1e-8)

    def test_forces(self):
        # a table on four legs, weight 4: three motions, which each leg feels
        H = np.array([[1, 1, 1, 1], [1, -1, 1, -1], [1, 1, -1, -1.0]])
        for start in (None, [1.5, .5, .5, 1.5]):
            s = delassus.solve(H.T @ H, [-4.0] * 4, d=1, r0=start)
            self.assertEqual((s.forces, s.freedom), ("any", 1))
            s = delassus.solve(H.T @ H, [-4.0] * 4, d=1, r0=start, forces="least")
            self.assertEqual((s.forces, s.freedom), ("least", 1))
            np.testing.assert_allclose(s.r, np.ones((4, 1)), rtol=1e-9)
        self.assertEqual(delassus.solve(np.eye(2), [-1.0, 0.0], [0.5]).freedom, 0)
        with self.assertRaisesRegex(ValueError, "forces: 'most' is none of any, least"):
            delassus.solve(np.eye(2), [-1.0, 0.0], [0.5], forces="most")

    def test_proof(self):
        W, q = coupled(3, 20)
        for a in (W, sp.coo_matrix(W)):
            s = delassus.solve(a, q, 0.3)
            p = s.proof
            self.assertEqual((p.proved, p.freedom, p.border), ("reactions", 0, None))
            self.assertLess(p.radius, 1e-11)
            exact = delassus.solve(W, q, 0.3, tol=1e-14).r
            size = np.linalg.norm(exact)
            self.assertLessEqual(np.linalg.norm(p.improved - exact), 1e-11 * size)
            self.assertLessEqual(np.linalg.norm(s.r - exact), (p.error + 1e-11) * size)
            self.assertEqual(pickle.loads(pickle.dumps(s)).proof.radius, p.radius)
        slip = delassus.solve(np.eye(2), [-1.0, 0.5], [0.5]).proof  # r_t = -0.5 = -mu r_n, u_t = 0
        self.assertIsNone(slip.proved)
        self.assertEqual(slip.border[0], 0)
        self.assertEqual(set(slip.border[1:]), {"stick", "slip"})
        for W in (np.array([[1, .5], [.5, 1]]), np.array([[1, .5, 0], [.5, 1, 0], [0, 0, 1]])):
            d = len(W)  # one contact folds at W_nn / |W_nt|
            f = delassus.solve(W, [-1.0] + (d - 1) * [0.0], 0.1).fold
            self.assertTrue(f.exact == (d == 2) and abs(f.unique - 2) < 1e-12 and 0 <= f.friction - f.unique < 4e-6)
            for r in (f.r, f.other):
                self.assertLess(delassus.certify(W, f.q, f.friction, r).residual, 1e-12)
            self.assertGreater(np.abs(f.r - f.other).max(), 1e-7 * np.abs(f.r).max())
        with self.assertRaises(delassus.UnsupportedError):
            delassus.solve(np.eye(1), [-1.0], d=1).fold
        two = delassus.solve(np.kron(np.ones((2, 2)), np.eye(2)), [-1.0, 0, -1, 0], [0.5, 0.5]).proof
        self.assertEqual(two.freedom, 2)

    def test_dense_and_blocks_agree(self):
        for d, skew in ((2, 0.0), (3, 0.0), (2, 0.1), (3, 0.1)):
            W, q = coupled(d, 20, skew=skew)
            a = delassus.solve(W, q, 0.3, tol=1e-12)
            b = delassus.solve(sp.coo_matrix(W), q, 0.3, tol=1e-12)
            self.assertTrue(a.solved and b.solved)
            np.testing.assert_allclose(a.r, b.r, atol=1e-8 * abs(a.r).max())
            np.testing.assert_allclose(a.u.ravel(), W @ a.r.ravel() + q.ravel(), atol=1e-10)
            self.assertEqual(delassus.certify(W, q, 0.3, a.r), a.certificate)

    def test_plans(self):
        W, q = coupled(2, 12)
        W = W - 0.9 * np.linalg.eigvalsh(W)[0] * np.eye(24)
        s = delassus.solve(W, q, 0.8, plan="sweeps:4,newton:3", tol=1e-14)
        self.assertEqual([a.step for a in s.stages], ["anderson", "newton"])
        self.assertEqual(s.stages[0][1:3], (4, 0))
        self.assertEqual(s.stages[0].reason, "its iterations are spent")
        self.assertEqual((s.regime, s.stages[0].cpu_seconds), ("given", 0))
        self.assertIn("the plan is the caller's", s.explain())
        self.assertEqual(s.explain().count("\n"), 2 + len(s.stages))
        own = delassus.solve(W, q, 0.8, tol=1e-14, timed=True)
        self.assertEqual(own.regime, "elastic")
        self.assertGreater(sum(a.cpu_seconds for a in own.stages), 0)
        self.assertIn("s of CPU", own.explain())
        self.assertEqual(pickle.loads(pickle.dumps(own)).explain(), own.explain())
        for step in {a.step for a in own.stages}:
            less = delassus.solve(W, q, 0.8, tol=1e-14, without=step)
            self.assertNotIn(step, [a.step for a in less.stages])
        with self.assertRaises(delassus.Error) as caught:
            delassus.solve(W, q, 0.8, plan="newtn")
        self.assertIn("'newtn' is no step: sweeps anderson", str(caught.exception))
        self.assertEqual(caught.exception.argument, "plan")
        for wrong in (3, b"newton", "new\0ton", ["newton"]):
            with self.assertRaises(ValueError):
                delassus.solve(W, q, 0.8, without=wrong)

    def test_bodies(self):
        random = np.random.default_rng(5)
        for d, n in ((2, 3), (3, 6)):
            nc = 12
            body = np.array([[c, random.integers(-1, c) if c else -1] for c in range(nc)])
            H = random.uniform(-1, 1, (nc, 2, d, n))
            J = np.zeros((nc * d, nc * n))
            for c in range(nc):
                for side in range(2):
                    if body[c, side] >= 0:
                        at = n * body[c, side]
                        J[d * c:d * c + d, at:at + n] = H[c, side]
            q = random.uniform(-1, 1, (nc, d)) - np.eye(d)[0] / 2
            a = delassus.solve(J @ J.T, q, 0.3, tol=1e-12)
            b = delassus.solve((body, H), q, 0.3, tol=1e-12, threads=2)
            self.assertTrue(a.solved and b.solved)
            np.testing.assert_allclose(a.r, b.r, atol=1e-7 * abs(a.r).max())
            self.assertEqual(delassus.certify((body, H), q, 0.3, b.r), b.certificate)
            with self.assertRaises(ValueError):
                delassus.solve((body[1:], H), q, 0.3)

    def test_options(self):
        W, q = coupled(2, 30)
        s = delassus.solve(W, q, 0.3, method="nlgs", acceleration="anderson", history=True)
        self.assertEqual(s.method, "nlgs")
        self.assertEqual(s.history["iteration"][-1], s.iterations)
        self.assertEqual(s.history["residual"][-1], s.residual)
        again = delassus.solve(W, q, 0.3, method="nlgs", r0=s.r)
        np.testing.assert_array_equal(again.r, s.r)
        short = delassus.solve(W, q, 0.3, method="nlgs", tol=1e-14, max_iterations=2)
        self.assertEqual((short.status, short.solved), (delassus.DLS_MAX_ITERATIONS, False))
        stopped = delassus.solve(W, q, 0.3, method="nlgs", progress=lambda p: p.iteration >= 1)
        self.assertEqual(stopped.status, delassus.DLS_CANCELLED)

    def test_exception_of_progress(self):
        W, q = coupled(2, 30)

        def fails(_):
            raise KeyboardInterrupt

        with self.assertRaises(KeyboardInterrupt):
            delassus.solve(W, q, 0.3, method="nlgs", progress=fails)

    def test_dimension_from_sizes(self):
        """d follows from the sizes of q, mu and H; two answers are a question."""
        W, q = coupled(2, 5)
        flat = q.ravel()  # ten rows: d = 2 alone
        wanted = delassus.solve(W, q, 0.3).r
        for given in (dict(q=flat, mu=0.3), dict(q=flat, mu=[0.3] * 5), dict(q=flat, mu=0.3, d=2),
                      dict(q=flat.tolist(), mu=0.3), dict(q=q.tolist(), mu=0.3)):
            np.testing.assert_array_equal(delassus.solve(W, **given).r, wanted)
        self.assertEqual(delassus.solve(np.eye(2), [-1, 0], 0.3).r.shape, (1, 2))
        self.assertEqual(delassus.solve(np.eye(9), -np.ones(9), 0.3).r.shape, (3, 3))
        with self.assertRaisesRegex(ValueError, "fits d = 2 and d = 3: give d"):
            delassus.solve(np.eye(6), -np.ones(6), 0.3)
        with self.assertRaisesRegex(ValueError, "neither d = 2 nor d = 3"):
            delassus.solve(np.eye(5), -np.ones(5), 0.3)
        with self.assertRaisesRegex(ValueError, "mu is missing"):
            delassus.solve(np.eye(2), -np.ones(2))

    def test_normals_alone(self):
        W, q = [[2, 1, 0], [1, 2, 1], [0, 1, 2]], [-1, 3, -4]  # contacts 0 and 2 are pressed
        answers = [delassus.solve(W, q, 0), delassus.solve(W, q, d=1),
                   delassus.solve(sp.csc_matrix(W), q, [0, 0, 0]),
                   delassus.solve(tuple(map(tuple, W)), np.reshape(q, (3, 1)), 0)]
        for s in answers:
            self.assertTrue(s.solved)
            np.testing.assert_allclose(s.r, [[0.5], [0], [2]], atol=1e-12)
        with self.assertRaisesRegex(ValueError, r"mu\[1\] is 0.3, must be 0 where d = 1"):
            delassus.solve(W, q, [0, 0.3, 0])

    def test_every_option_is_named(self):
        import inspect
        for function in (delassus.solve, delassus.Reduction.solve, delassus.reduce,
                         delassus.certify, delassus.Motion.__init__, delassus.Motion.step):
            for parameter in inspect.signature(function).parameters.values():
                self.assertNotIn(parameter.kind, (parameter.VAR_KEYWORD, parameter.VAR_POSITIONAL))
                self.assertTrue(parameter.name == "self" or parameter.annotation != parameter.empty)
        with self.assertRaisesRegex(TypeError, "tolerance"):
            delassus.solve(np.eye(2), [-1, 0], 0.3, tolerance=1)

    def test_empty(self):
        s = delassus.solve(np.zeros((0, 0)), np.zeros((0, 3)), [])
        self.assertTrue(s.solved)
        self.assertEqual(s.r.shape, (0, 3))
        self.assertTrue(delassus.solve(sp.csc_matrix((4, 4)), np.ones((2, 2)), 0.1).solved)

    def test_any_layout_of_arrays(self):
        W, q = coupled(3, 8, skew=0.1)
        wanted = delassus.solve(W, q, 0.3).r
        for other in (np.asfortranarray(W), np.repeat(W, 2, axis=1)[:, ::2], W.tolist()):
            np.testing.assert_array_equal(delassus.solve(other, q, [0.3] * 8).r, wanted)

    def test_bad_input(self):
        W, q = coupled(2, 3)
        for wrong in (dict(W=W[:, :4], q=q, mu=0.3), dict(W=W, q=q[:2], mu=0.3),
                      dict(W=W, q=q.ravel(), mu=0.3), dict(W=W, q=q, mu=[0.3]),
                      dict(W=W, q=q, mu=0.3, d=4), dict(W=W, q=q, mu=0.3, method="none such"),
                      dict(W=W, q=q, mu=0.3, r0=[1]), dict(W=W, q=q, mu=0.3, acceleration="x")):
            with self.assertRaises(ValueError, msg=wrong.keys()):
                delassus.solve(**wrong)
        q[1, 1] = np.nan
        with self.assertRaises(delassus.Error) as caught:
            delassus.solve(W, q, 0.3)
        e = caught.exception
        self.assertEqual((e.status, e.name), (delassus.DLS_E_NOT_FINITE, "DLS_E_NOT_FINITE"))
        self.assertEqual((e.function, e.argument, e.index), ("dls_solve", "q", 3))
        self.assertIsInstance(e, ValueError)
        self.assertIn("q[3]", str(e))
        with self.assertRaises(delassus.Error) as caught:
            delassus.solve(W, np.nan_to_num(q), 0.3, tol=-1)
        self.assertIn("tol", caught.exception.argument)


class Derivatives(unittest.TestCase):
    def differences(self, answer, size, h=1e-4):
        """Returns d answer / dh at 0 by two central differences, extrapolated."""
        one, two = ((answer(k) - answer(-k)) / (2 * k) for k in (h, h / 2))
        np.testing.assert_allclose(one, two, atol=1e-4 * size)
        return two + (two - one) / 3

    def test_of_W(self):
        random = np.random.default_rng(4)
        for d in (1, 2, 3):
            W, q = coupled(d, 8, skew=0.1)
            mu = 0 * np.arange(8) if d == 1 else 0.1 + 0.05 * np.arange(8)
            dW, dq, dmu = W * random.random(W.shape), random.random(q.shape), mu * random.random(8)

            def answer(h):
                s = delassus.solve(W + h * dW, q + h * dq, mu + h * dmu, d=d, tol=1e-13)
                return np.concatenate((s.proof.improved, s.u))

            s = delassus.solve(W, q, mu, d=d, tol=1e-13)
            D, size = self.differences(answer, 1), np.linalg.norm(answer(0))
            moved = s.jvp(q=dq, mu=dmu, W=dW)
            self.assertIsNone(moved.x)
            np.testing.assert_allclose(np.concatenate(moved[:2]), D, atol=1e-7 * size)
            r, u = random.random(q.shape), random.random(q.shape)
            expected = np.sum(r * moved.r + u * moved.u)
            for matrix in (W, sp.csr_matrix(W)):
                t = delassus.solve(matrix, q, mu, d=d, tol=1e-13)
                g = t.vjp(r, u)
                self.assertIsNone(g.f)
                change = g.W.multiply(dW).sum() if sp.issparse(matrix) else np.sum(g.W * dW)
                self.assertAlmostEqual(np.sum(g.q * dq) + g.mu @ dmu + change, expected, 9)
            np.testing.assert_array_equal(pickle.loads(pickle.dumps(s)).vjp(r, u).q,
                                          s.vjp(r, u).q)

    def test_of_rigid_bodies(self):
        random = np.random.default_rng(5)
        body, H = np.array([[0, -1], [0, 1], [1, -1]]), random.random((3, 2, 2, 3)) - 0.5
        dH, q = random.random(H.shape), [[-1, 0.2], [-1, 0.1], [-1, -0.3]]
        s = delassus.solve((body, H), q, 0.3, tol=1e-13)
        D = self.differences(lambda h: delassus.solve((body, H + h * dH), q, 0.3, tol=1e-13)
                             .proof.improved, 10, 1e-5)
        moved = s.jvp(W=dH)
        np.testing.assert_allclose(moved.r, D, atol=1e-6 * np.linalg.norm(D))
        g = s.vjp(r=np.ones((3, 2)))
        self.assertAlmostEqual(np.sum(g.W * dH), moved.r.sum(), 9)
        self.assertEqual(np.linalg.norm(g.W[0, 1]), 0)  # a fixed body

    def test_of_a_body(self):
        random = np.random.default_rng(6)
        for on in ("W", "K"):
            K, HN, HT = chain(40)
            f = np.where(np.arange(40) % 2, -1.0, 0.3) + 0.1 * random.random(40)
            df, dg, dmu = random.random(40), random.random((10, 2)), random.random(10)
            dK = K.copy()
            dK.data = K.data * 0.1
            dK = dK + sp.diags(0.1 * random.random(40)).tocsc()
            R = delassus.reduce(K, HN, HT, on=on)
            s = R.solve(0.3, f=f, tol=1e-13)
            moved = s.jvp(f=df, g=dg, mu=dmu, K=dK)

            def answer(h):
                t = delassus.reduce(K + h * dK, HN, HT, on=on)
                return t.solve(0.3 + h * dmu, f=f + h * df, g=h * dg, tol=1e-13).x

            np.testing.assert_allclose(moved.x, self.differences(answer, 10, 1e-5),
                                       atol=1e-6 * np.linalg.norm(moved.x))
            r, u, x = random.random((10, 2)), random.random((10, 2)), random.random(40)
            g = s.vjp(r, u, x)
            self.assertIsNone(g.q)
            self.assertEqual(g.K.nnz, K.nnz)
            self.assertAlmostEqual(
                g.f @ df + np.sum(g.g * dg) + g.mu @ dmu + g.K.multiply(dK).sum(),
                np.sum(r * moved.r + u * moved.u) + x @ moved.x, 8)
            R.load(2 * f)
            np.testing.assert_array_equal(s.vjp(r, u, x).f, g.f)
            with self.assertRaisesRegex(ValueError, "another load"):
                s.vjp(r, side=0)
            R.update(K, HN, HT)
            with self.assertRaisesRegex(ValueError, "another load or K"):
                s.vjp(r, u, x)
            with self.assertRaisesRegex(ValueError, "pickled"):
                pickle.loads(pickle.dumps(s)).vjp(r)

    def test_none(self):
        s = delassus.solve(np.eye(2), [-1.0, 0.5], [0.5])  # r_t = -0.5 = -mu r_n, u_t = 0
        with self.assertRaisesRegex(delassus.NoDerivativeError, "stick and slip") as caught:
            s.vjp([1, 0])
        self.assertEqual((caught.exception.index, caught.exception.argument), (0, "contact"))
        self.assertIsInstance(caught.exception, ArithmeticError)
        np.testing.assert_array_equal(s.jvp(q=[0, 1], side=0).r, [[0, -1]])
        np.testing.assert_array_equal(s.jvp(q=[0, 1], side=1).r, [[0, 0]])
        two = delassus.solve(np.kron(np.ones((2, 2)), np.eye(2)), [-1.0, 0, -1, 0], [0.5, 0.5])
        self.assertRaises(delassus.NoDerivativeError, two.vjp, [1, 0, 0, 0])
        for arguments in ({"x": [1]}, {"r": [1]}, {"r": "a"}, {"side": 2}):
            self.assertRaises(ValueError, s.vjp, **{"side": 0, **arguments})
        for arguments in ({"f": [1]}, {"K": np.eye(2)}, {"W": np.eye(3)}, {"q": [1]}):
            self.assertRaises(ValueError, s.jvp, side=0, **arguments)


try:
    import torch
except ImportError:
    torch = None


class Torch(unittest.TestCase):
    def check(self, function, *tensors):
        tensors = [torch.tensor(t, dtype=torch.float64, requires_grad=True) for t in tensors]
        self.assertTrue(torch.autograd.gradcheck(function, tensors, eps=1e-6, atol=1e-6, rtol=1e-6))

    def test_layers(self):
        if torch is None:
            print("left out: delassus.torch, no torch (Debian: python3-torch, 180 MB)")
            self.assertRaises(ImportError, __import__, "delassus.torch")
            return
        from delassus.torch import NotSolvedError, solve, solve_body

        W, q = coupled(3, 6)
        self.check(lambda W, q, mu: solve(W, q, mu, tol=1e-13), W / 18 + np.eye(18), q - 0.5,
                   0.2 + 0.1 * np.arange(6))
        self.check(lambda mu: solve(W, q, mu, tol=1e-13), 0.3)
        K, HN, HT = POINT
        self.check(lambda a, f, g, mu: solve_body(a @ a.T, f, g, mu, HN=HN, HT=HT, tol=1e-13),
                   np.linalg.cholesky(K), [5, -10], [[0.1, 0]], [0.2])
        R = delassus.reduce(K, HN, HT)
        self.check(lambda f, mu: solve_body(R, f, None, mu, tol=1e-13), [5, -10], [0.2])
        load = torch.tensor([5.0, -10.0], requires_grad=True)  # single precision
        solve_body(R, load, None, 0.2)[2].sum().backward()
        np.testing.assert_allclose(load.grad.numpy(), [0.3125, 0.0625], rtol=1e-6)
        q = torch.tensor([-1, 0.5], dtype=torch.float64, requires_grad=True)
        r, _ = solve(np.eye(2), q, [0.5])
        self.assertRaises(delassus.NoDerivativeError, r.sum().backward)
        solve(np.eye(2), q, [0.5], side=0)[0].sum().backward()
        np.testing.assert_array_equal(q.grad.numpy(), [-1, -1])
        self.assertRaises(NotSolvedError, solve, np.eye(2) * -1, [-1.0, 0.5], [0.5])


class Reduce(unittest.TestCase):
    def test_every_operator(self):
        K, HN, HT = POINT  # docs/tour.md
        operators = [dict(K=K), dict(K=sp.csr_matrix(K)),
                     dict(K=np.linalg.inv(K), flexibility=True),
                     dict(K=scipy.sparse.linalg.splu(sp.csc_matrix(K)).solve),
                     dict(K=K, factorization="lu"), dict(K=sp.csc_matrix(K), factorization="ldlt")]
        for operator in operators:
            R = delassus.reduce(HN=HN, HT=HT, **operator)
            s = R.solve(0.2, f=[5, -10])
            np.testing.assert_allclose(s.r, [[10.9375, -2.1875]], rtol=1e-12)
            np.testing.assert_allclose(s.x, [0.9375, 0], atol=1e-12)
            np.testing.assert_allclose(R.W, [[0.6, -0.2], [-0.2, 0.4]], rtol=1e-12)
            np.testing.assert_allclose(R.q, [[-7, 4]], rtol=1e-12)
            self.assertEqual((R.d, R.n, R.m, R.candidates), (2, 2, 2, 1))

    def test_steps(self):
        K, HN, HT = POINT
        R = delassus.reduce(K, HN, HT)
        R.load(f=[0, 0], g=[[1, 0]])
        np.testing.assert_array_equal(R.q, [[1, 0]])
        R.load_free(np.linalg.solve(K, [5, -10]))
        np.testing.assert_allclose(R.solve(0.2).x, [0.9375, 0], atol=1e-12)
        R.update(2 * K, HN, HT)
        np.testing.assert_allclose(R.W, [[0.3, -0.1], [-0.1, 0.2]], rtol=1e-12)
        np.testing.assert_array_equal(R.nodal([[1, 2]]), [[1, 2]])
        s = R.solve(0.2, f=[5, -10])
        self.assertEqual(R.certify(s.r, s.x, 0.2), s.certificate)
        self.assertEqual(R.info["W_bytes"], 32)

    def test_without_tangents(self):
        # a membrane over a flat obstacle, without HT: d = 1, W by normals alone, or K
        n = 12
        line = sp.diags([2., -1., -1.], [0, 1, -1], (n, n))
        K = (sp.kron(line, sp.eye(n)) + sp.kron(sp.eye(n), line)).tocsc()
        I, f, g = sp.eye(n * n, format="csc"), np.full(n * n, -1e-2), np.full(n * n, 0.1)
        exact = delassus.reduce(K, I, sp.csc_matrix((n * n, n * n))).solve(0, f=f, g=np.column_stack([g, 0 * g]))
        for on in (None, "W", "K"):
            R = delassus.reduce(K, I, on=on)
            self.assertEqual((R.d, R.m), (1, n * n))
            s = R.solve(f=f, g=g, tol=1e-14)
            self.assertTrue(s.solved)
            self.assertEqual((s.r.shape, s.u.shape), ((n * n, 1), (n * n, 1)))
            np.testing.assert_allclose(s.r[:, 0], exact.r[:, 0], atol=1e-9)
            np.testing.assert_allclose(s.x, exact.x, atol=1e-9)
            np.testing.assert_allclose(K @ s.x, f + s.r[:, 0], atol=1e-12)
            np.testing.assert_allclose(s.u[:, 0], s.x + g, atol=1e-9)
            self.assertTrue(0 < (s.states == "free").sum() < n * n)
            self.assertEqual(R.nodal(s.r).shape, (n * n, 1))
            # dx/dg and its transpose
            way, moved = np.cos(np.arange(n * n)), None
            moved = s.jvp(g=way)
            h = 1e-5
            R.load(f, g + h * way)
            np.testing.assert_allclose(moved.x, (R.solve(tol=1e-14).x - s.x) / h, atol=1e-6)
            R.load(f, g)
            s = R.solve(tol=1e-14)
            self.assertAlmostEqual(s.vjp(x=way).g[:, 0] @ way, way @ s.jvp(g=way).x, 8)
            np.testing.assert_array_equal(R.solve(0, f=f, g=g[:, None], tol=1e-14).x, s.x)
            if on == "W":
                self.assertEqual(R.W.shape, (n * n, n * n))
                self.assertEqual(R.q.shape, (n * n, 1))
        # friction without tangents: no silence
        for call in (lambda: R.solve(0.3), lambda: delassus.reduce(K, I, mu=np.full(n * n, 0.3)),
                     lambda: delassus.Motion(K, I, law="path").step(f, mu=0.3),
                     lambda: R.update(K, I, I)):
            with self.assertRaisesRegex(ValueError, "HT is"):
                call()
        with self.assertRaisesRegex(ValueError, "g has 288"):
            R.load(g=np.zeros((n * n, 2)))

    def test_no_dense_tangents(self):
        # zeros of n x nodes would take 5 GB
        n = 25000
        R = delassus.reduce(sp.diags([3.0, -1.0, -1.0], [0, 1, -1], (n, n), format="csc"), sp.eye(n, format="csc"))
        s = R.solve(f=np.where(np.arange(n) % 2, 1.0, -2.0))
        self.assertTrue(s.solved)
        self.assertLess(R.info["bytes"], 1e9)

    def test_parts(self):
        K, HN, HT = chain(40)
        active = np.arange(HN.shape[1]) % 2
        R = delassus.reduce(K, HN, HT, active=active)
        self.assertEqual(R.candidates, active.sum())
        self.assertEqual(len(R.solve(0.3, f=-np.ones(40)).r), active.sum())
        no_friction = delassus.reduce(K, HN).solve(f=-np.ones(40))
        self.assertTrue(no_friction.solved)
        self.assertEqual(no_friction.r.shape, (no_friction.r.size, 1))
        with_mu = delassus.reduce(K, HN, HT, mu=np.full(HN.shape[1], 0.3)).solve(f=-np.ones(40))
        given = delassus.reduce(K, HN, HT).solve(0.3, f=-np.ones(40))
        np.testing.assert_array_equal(with_mu.r, given.r)

    def test_free_body(self):
        K = sp.csc_matrix([[1.0, -1.0], [-1.0, 1.0]])
        HN = np.array([[1.0], [0.0]])
        with self.assertRaises(delassus.Error) as caught:
            delassus.reduce(K, HN, on="W")
        self.assertEqual(caught.exception.name, "DLS_E_SINGULAR")
        self.assertIsInstance(caught.exception, np.linalg.LinAlgError)
        for options in ({}, {"on": "K"}):
            R = delassus.reduce(K, HN, **options)
            self.assertEqual(R.on, "K")
            solution = R.solve(f=[0, -10])
            self.assertTrue(solution.solved)
            np.testing.assert_allclose(solution.r, [[10]], rtol=1e-9)
            np.testing.assert_allclose(solution.x, [0, -10], atol=1e-9)
            self.assertEqual(list(solution.states), ["touch"])
            for refused in (lambda: R.W, lambda: R.recover([[1]]),
                            lambda: R.solve(method="nlgs")):
                with self.assertRaises(delassus.Error) as caught:
                    refused()
                self.assertEqual(caught.exception.name, "DLS_E_UNSUPPORTED")
                self.assertIsInstance(caught.exception, NotImplementedError)
        self.assertFalse(R.solve(f=[0, 10]).solved)

    def test_place(self):
        K, HN, HT = chain(40)
        self.assertEqual(delassus.reduce(K, HN, HT).on, "W")
        on_K = delassus.reduce(K, HN, HT, on="K")
        by_K = on_K.solve(0.3, f=-np.ones(40), tol=1e-12)
        by_W = delassus.reduce(K, HN, HT, on="W").solve(0.3, f=-np.ones(40), tol=1e-12)
        np.testing.assert_allclose(by_K.r, by_W.r, atol=1e-10)
        self.assertEqual(list(by_K.states), list(by_W.states))
        warm = on_K.solve(0.3, f=-np.ones(40), tol=1e-12, r0=by_K.r)
        self.assertLessEqual(warm.iterations, 2)
        on_K.update(2 * K, HN, HT)
        np.testing.assert_allclose(on_K.solve(0.3, f=-np.ones(40), tol=1e-12).x, by_W.x / 2,
                                   atol=1e-9)
        with self.assertRaises(delassus.Error) as caught:
            delassus.reduce(K, HN, HT, memory_limit=100)
        self.assertEqual(caught.exception.argument, "memory_limit")
        self.assertIsInstance(caught.exception, MemoryError)
        with self.assertRaises(ValueError):
            delassus.reduce(K, HN, HT, on="V")
        with self.assertRaises(delassus.Error):
            delassus.reduce(lambda B: np.linalg.solve(K.toarray(), B), HN, HT, on="K")

    def test_host_that_fails(self):
        _, HN, HT = POINT
        with self.assertRaises(ZeroDivisionError):
            delassus.reduce(lambda B: 1 / 0, HN, HT)
        with self.assertRaises(ValueError):
            delassus.reduce(lambda B: B[:1], HN, HT)

    def test_bad_input(self):
        K, HN, HT = POINT
        for wrong in (dict(K=K[:1]), dict(K=np.triu(K)), dict(K=sp.triu(K)),
                      dict(K=K, factorization="qr"), dict(K=K, active=[1, 1]),
                      dict(K=K, mu=[1, 1])):
            with self.assertRaises(ValueError, msg=wrong.keys()):
                delassus.reduce(HN=HN, HT=HT, **wrong)
        with self.assertRaises(ValueError):
            delassus.reduce(K, HN, np.ones((2, 3)))
        R = delassus.reduce(K, HN, HT)
        with self.assertRaisesRegex(ValueError, "f has 1 entry, needs 2"):
            R.load(f=[1])
        for call in (lambda: R.load(f=[1]), lambda: R.load(g=[1]), lambda: R.recover([1])):
            with self.assertRaises(ValueError):
                call()

    def test_views_outlive_the_name(self):
        W = delassus.reduce(*POINT).W
        self.assertFalse(W.flags.writeable)
        np.testing.assert_allclose(W, [[0.6, -0.2], [-0.2, 0.4]], rtol=1e-12)


class Surface(unittest.TestCase):
    """A chain whose contact moves, with K factorised once."""

    def setUp(self):
        self.K, _, _ = chain(400)
        self.f = -np.ones(400)

    def sides(self, *at):
        HN = sp.csc_matrix((np.ones(len(at)), (at, range(len(at)))), (400, len(at)))
        HT = sp.csc_matrix((np.ones(len(at)), (np.add(at, 1), range(len(at)))), (400, len(at)))
        return HN, HT

    def test_moves(self):
        red = delassus.reduce(self.K, *self.sides(10), surface=np.arange(5, 60))
        red.load(self.f)
        W, q = red.W, red.q
        before = W.copy(), q.copy()
        for at, g in (((20, 30), None), ((5, 40, 58), np.full((3, 2), -.5)), ((), None), ((12,), None)):
            red.move(*self.sides(*at), g=g)
            other = delassus.reduce(self.K, *self.sides(*at))
            other.load(self.f, g)
            self.assertEqual((red.m, red.candidates), (2 * len(at), len(at)))
            np.testing.assert_allclose(red.W, other.W, rtol=1e-12)
            np.testing.assert_allclose(red.q, other.q, rtol=1e-12)
            a, b = red.solve(0.3), other.solve(0.3)
            self.assertTrue(a.solved and b.solved)
            np.testing.assert_allclose(a.x, b.x, rtol=1e-9, atol=1e-9 * np.abs(b.x).max())
        np.testing.assert_array_equal(W, before[0])  # copies, which outlive the library's arrays
        np.testing.assert_array_equal(q, before[1])
        red.move(*self.sides(12, 14), mu=[0.0, 0.2], active=[0, 1])
        self.assertEqual(red.candidates, 1)
        red.update(self.K, *self.sides(12, 14))
        red.load(self.f)
        a, b = red.solve(), delassus.reduce(self.K, *self.sides(14)).solve(0.2, self.f)
        np.testing.assert_allclose(a.r, b.r, rtol=1e-9)

    def test_bad_input(self):
        red = delassus.reduce(self.K, *self.sides(10), surface=[20, 21])
        off = (self.sides(19),) if red.info["condensed"] else ()  # a whole factor takes any unknown
        for wrong in (*off, (self.sides(10)[0][:300],), (self.sides(10, 20)[0], self.sides(10)[1])):
            with self.assertRaises(ValueError):
                red.move(*wrong)
        with self.assertRaises(ValueError):
            red.move(*self.sides(20), g=[1.0, 2.0, 3.0])
        self.assertEqual(red.m, 2)
        self.assertTrue(red.solve(0.1, self.f).solved)
        for surface in ([400], [-1], [0.5]):
            with self.assertRaises(ValueError):
                delassus.reduce(self.K, *self.sides(10), surface=surface)
        with self.assertRaises(ValueError):
            delassus.reduce(self.K, *self.sides(10)).move(*self.sides(10))

    def test_derivatives_end(self):
        red = delassus.reduce(self.K, *self.sides(10), surface=[20, 21])
        s = red.solve(0.3, self.f)
        red.move(*self.sides(20))
        with self.assertRaises(ValueError):
            s.vjp(r=np.ones((1, 2)))


class Geometry(unittest.TestCase):
    def test_pairs(self):
        X = [[0, 0], [4, 0], [1, .5], [9, 9]]
        p = delassus.pairs(X, [2, 3], [[1, 0]], dof=[[-1, -1], [7, 3], [0, 5], [1, 2]], n=8)
        np.testing.assert_allclose(p.HN.toarray()[:, 0], [0, 0, 0, -.25, 0, 1, 0, 0])
        np.testing.assert_allclose(p.HT.toarray()[:, 0], [1, 0, 0, 0, 0, 0, 0, -.25])
        self.assertEqual((p.g.tolist(), p.node.tolist(), p.face.tolist()), ([[.5, 0]], [2], [0]))
        self.assertEqual((p.state.tolist(), p.P, p.measure), (["found", "far"], None, None))
        np.testing.assert_allclose(p.frame, [[[0, 1], [1, 0]]])
        wall = delassus.pairs(np.add(X, 0.0), [3, 4], wall=([0, 1], [0, 1]), base=1)
        self.assertEqual((wall.g[:, 0].tolist(), wall.HN.shape), ([-.5, 8], (8, 2)))

    def test_mortar(self):
        x, y = np.linspace(0, 1, 4), np.linspace(0, 1, 6)
        X = np.r_[np.c_[x, 0 * x], np.c_[y, 0 * y]]
        face = np.c_[1:4, 0:3]
        own = np.c_[4:9, 5:10]
        p = delassus.pairs(X, face=face, own=own)
        R = (p.HN @ (p.P @ p.measure)).reshape(-1, 2)[:, 1]
        np.testing.assert_allclose(R, [-1/6, -1/3, -1/3, -1/6, .1, .2, .2, .2, .2, .1])
        self.assertEqual((p.node.tolist(), p.state), (list(range(4, 10)), None))

    def test_bad_pairs(self):
        X = [[0, 0], [4, 0], [1, .5]]
        good = dict(node=[2], face=[[1, 0]])
        for change in (dict(node=[3]), dict(face=[[1, 1]]), dict(face=[1, 0]), dict(face=[[0, 1, 2]]), dict(reach=-1),
                       dict(dof=[[0, 1]]), dict(n=4), dict(base=2), dict(node=[2, 2]), dict(wall=([0, 0], [0, 1])),
                       dict(wall=([0, 0, 0], [0, 1])), dict(face=[[1.5, 0]]), dict(own=[[5, 0]])):
            with self.assertRaises(ValueError, msg=str(change)):
                delassus.pairs(X, **{**good, **change})
        for X in ([[0, 0, 0, 0]], [0, 1], [[np.nan, 0], [4, 0], [1, .5]]):
            with self.assertRaises(ValueError):
                delassus.pairs(X, **good)

    def test_rigid_bodies(self):
        # a cube of side 2 falls on the floor, its speed across by friction 1/4 slowed down
        b = delassus.RigidBodies(3.0, 2 * np.eye(3), np.eye(3), [0, 0, 1], [1, 0, -2], [0, 0, 0])
        corner = np.array([[i, j, 0] for i in (-1, 1) for j in (-1, 1)], float)
        W, q = b.contacts([[0, -1]] * 4, corner * 4, [[0, 0, 5]] * 4)
        self.assertEqual((W[0].tolist(), W[1].shape), ([[0, -1]] * 4, (4, 2, 3, 6)))
        s = delassus.solve(W, q, 0.25, tol=1e-12)
        b.apply(s.r)
        np.testing.assert_allclose(s.r[:, 0].sum(), 6)
        np.testing.assert_allclose(b.v[0], [.5, 0, 0], atol=1e-9)
        with self.assertRaises(ValueError):
            b.contacts([[0, 1]], [[0, 0, 0]], [[0, 0, 1]])
        with self.assertRaises(ValueError):
            b.apply(np.ones(5))
        with self.assertRaises(ValueError):
            delassus.RigidBodies(1, np.eye(3), np.eye(3), 0, 0, 0).apply([])
        with self.assertRaises(ValueError):
            delassus.RigidBodies(-1, np.eye(3), np.eye(3), 0, 0, 0).contacts([[0, -1]], [0, 0, 0], [0, 0, 1])


class Motion(unittest.TestCase):
    def ball(self, **settings):
        _, HN, HT = POINT
        return delassus.Motion(None, HN, HT, M=np.eye(2), gap=[0.05], h=0.01, **settings)

    def test_ball(self):
        ball = self.ball()
        for _ in range(5):
            self.assertIsNone(ball.step([0, -10], mu=0.3))
        np.testing.assert_allclose(ball.v, [0, -0.5], rtol=1e-12)
        for _ in range(30):
            s = ball.step([0.1, -10], mu=0.3)
        np.testing.assert_allclose(ball.p[0], [0.1, -0.001], rtol=1e-8)  # weight and push times h
        self.assertEqual((list(ball.states), list(s.states)), (["stick"], ["stick"]))
        np.testing.assert_array_equal(s.r, ball.p)
        e = ball.energies
        self.assertLessEqual(e["residual"], 1e-12 * e["scale"])
        self.assertEqual(ball.steps, 35)
        ball.start(x=[0, 1], v=[1, 0], t=2)
        ball.set_h(0.02)
        ball.step()
        np.testing.assert_allclose(ball.x, [0.02, 1], rtol=1e-12)
        self.assertAlmostEqual(ball.t, 2.02)

    def test_path(self):
        K, HN, HT = POINT
        path = delassus.Motion(K, HN, HT, law="path")
        s = path.step([5, -10], mu=0.2)
        np.testing.assert_allclose(path.x, [0.9375, 0], atol=1e-10)
        np.testing.assert_allclose(s.r, [[10.9375, -2.1875]], rtol=1e-10)
        np.testing.assert_allclose(path.slip, [[0.9375]], rtol=1e-10)

    def test_path_on_K(self):  # nothing but friction holds the body along its tangent
        N, T = np.array([[0.0], [1.0]]), np.array([[1.0], [0.0]])
        path = delassus.Motion(np.zeros((2, 2)), N, T, law="path", gap=[0.25])
        s = path.step([1, -10], mu=0.2)
        self.assertTrue(s.solved)
        np.testing.assert_allclose(s.r, [[10, -1]], rtol=1e-9)
        np.testing.assert_allclose(s.u, [[0, 0]], atol=1e-9)
        np.testing.assert_allclose(path.x, [0, -0.25], atol=1e-9)
        self.assertEqual(list(s.states), ["stick"])
        self.assertIn("K", s.explain())

    def test_bad_input(self):
        with self.assertRaisesRegex(TypeError, "no_such_setting"):
            self.ball(no_such_setting=1)
        with self.assertRaises(ValueError):
            self.ball(law="none")
        with self.assertRaises(delassus.Error) as caught:
            self.ball(theta=2.0)
        self.assertEqual(caught.exception.argument, "theta")

    def test_membrane_on_K(self):
        # the contact problem is that on K: a Solution of all contacts
        n = 40
        line = sp.diags([2., -1., -1.], [0, 1, -1], (n, n))
        K = (sp.kron(line, sp.eye(n)) + sp.kron(sp.eye(n), line)).tocsc()
        motion = delassus.Motion(K, sp.eye(n * n, format="csc"), law="path", gap=0.05)
        for load in (-1e-3, -2e-3):
            s = motion.step(np.full(n * n, load))
            self.assertTrue(s.solved)
            np.testing.assert_allclose(K @ s.x, load + s.r[:, 0], atol=1e-9)
            np.testing.assert_allclose(s.u[:, 0], s.x + 0.05, atol=1e-9)
            np.testing.assert_array_equal(s.states, motion.states)
            self.assertTrue(0 < (s.states == "free").sum() < n * n)


class Many(unittest.TestCase):
    def test_stack_and_list(self):
        rng = np.random.default_rng(5)
        for nc, d in ((1, 3), (4, 2), (8, 3), (9, 3), (3, 1)):
            m, count = nc * d, 37
            A = rng.normal(size=(count, m, m + 2))
            # not symmetric: rows and columns must not be mixed up
            W = A @ A.transpose(0, 2, 1) + 0.1 * np.triu(np.ones((m, m)), 1)
            q = rng.normal(size=(count, nc, d))
            mu = rng.uniform(0, 0.5, (count, nc)) if d > 1 else 0.0
            batch = delassus.solve_many(W, q, mu)
            listed = delassus.solve_many(list(W), list(q), list(mu) if d > 1 else 0, d)
            flat = delassus.solve_many(W, q.reshape(count, m), mu, d)
            self.assertEqual((len(batch), batch.r.shape), (count, (count, nc, d)))
            np.testing.assert_array_equal(flat.r, batch.r)
            for k in range(count):
                single = mu[k] if d > 1 else 0
                one = delassus.solve(W[k], q[k], single, d)
                self.assertEqual(one.solved, batch.solved[k])
                np.testing.assert_array_equal(listed.r[k], batch.r[k])
                if not one.solved:
                    continue
                np.testing.assert_allclose(batch.r[k], one.r, atol=1e-6 * (1 + abs(one.r).max()))
                np.testing.assert_allclose(batch.u[k].reshape(-1),
                                           W[k] @ batch.r[k].reshape(-1) + q[k].reshape(-1), atol=1e-10)
                self.assertLess(delassus.certify(W[k], q[k], single, batch.r[k], d).residual, 1e-7)
                self.assertEqual(batch[k].residual, batch.residual[k])
            np.testing.assert_array_equal(batch[-1].r, batch.r[-1])
            self.assertEqual(len(list(batch)), count)
            self.assertEqual(batch[1].proof.proved, delassus.solve(W[1], q[1], mu[1] if d > 1 else 0, d).proof.proved)
            fewer = delassus.solve_many(W, q, mu, max_iterations=1, method="nlgs")
            self.assertEqual(fewer.status[0], fewer[0].status)

    def test_sizes_and_kinds(self):
        W = [np.diag([1.0, 2.0]), sp.eye(4, format="csc"), (np.array([[0, -1]]), np.ones((1, 2, 2, 3)))]
        q = [[-1.0, 0.0], [[-1.0, 0.0], [1.0, 0.0]], [-1.0, 0.1]]
        batch = delassus.solve_many(W, q, [0.5, [0.1, 0.2], 0.3], 2)
        for k in range(3):
            one = delassus.solve(W[k], q[k], [0.5, [0.1, 0.2], 0.3][k], 2)
            np.testing.assert_array_equal(batch[k].r, one.r)
            self.assertEqual(batch[k].words, one.words)
        self.assertEqual(len(delassus.solve_many([], [], [])), 0)
        self.assertEqual(delassus.solve_many(np.zeros((0, 2, 2)), np.zeros((0, 1, 2)), 0.5).r.shape, (0, 1, 2))

    def test_bad_input(self):
        W, q = np.tile(np.eye(4), (3, 1, 1)), np.ones((3, 2, 2))
        for wrong in (dict(W=W[0]), dict(q=q[:2]), dict(q=np.ones((3, 5))), dict(mu=np.ones(3)),
                      dict(mu=None), dict(method="none"), dict(W=W[:, :3]), dict(d=1, mu=1),
                      dict(d=3), dict(W=W.astype(complex)), dict(tol=[1]),
                      dict(W=list(W), q=list(q)[:2]), dict(W=list(W), mu=[1, 2]),
                      dict(W=[W[0], W[1], np.eye(3)], q=list(q))):
            with self.assertRaises(ValueError, msg=wrong.keys()):
                delassus.solve_many(**{**dict(W=W, q=q, mu=0.5), **wrong})
        q[2, 0, 0] = np.nan
        with self.assertRaises(delassus.InputError) as caught:
            delassus.solve_many(W, q, 0.5)
        self.assertEqual((caught.exception.argument, caught.exception.index), ("problem", 2))


class Steps(unittest.TestCase):
    def test_contacts_come_and_go(self):
        rng = np.random.default_rng(2)
        points = rng.uniform(size=60)
        W = np.kron(np.exp(-6 * abs(points[:, None] - points)), np.eye(2)) + 1e-3 * np.eye(120)
        solver = delassus.Solver(60, 2, tol=1e-10)
        warm = cold = 0
        names = np.arange(60) + 1000
        for step in range(8):
            here = np.sort(rng.permutation(60)[:50])
            rows = (2 * here[:, None] + [0, 1]).reshape(-1)
            q = np.column_stack([-1 + 0.1 * np.cos(7 * points[here] + 0.02 * step), np.full(50, 0.3)])
            s = solver.solve(W[np.ix_(rows, rows)], q, 0.4, contacts=names[here])
            one = delassus.solve(W[np.ix_(rows, rows)], q, 0.4, tol=1e-10)
            self.assertTrue(s.solved)
            np.testing.assert_allclose(s.r, one.r, atol=1e-6)
            self.assertEqual(s.proof.proved, "reactions")
            warm, cold = warm + s.iterations * (step > 0), cold + one.iterations * (step > 0)
        self.assertLess(warm, cold)
        # the same problem again, without names: nothing is left to do
        q = np.tile([-1.0, 0.3], (60, 1))
        solver.solve(W, q, 0.4)
        again = solver.solve(W, q, 0.4)
        self.assertTrue(again.solved and again.iterations <= 1)

    def test_sparse(self):
        line = sp.kron(sp.diags([2.5, -1.0, -1.0], [0, 1, -1], (30, 30)), sp.eye(2)).tocsc()
        solver = delassus.Solver(30, 2, blocks=88)
        for push in (-1.0, -1.1):
            s = solver.solve(line, np.tile([push, 0.2], (30, 1)), 0.3)
            self.assertTrue(s.solved)
            np.testing.assert_allclose(s.r, delassus.solve(line, np.tile([push, 0.2], (30, 1)), 0.3).r, atol=1e-6)

    def test_bad_input(self):
        solver = delassus.Solver(2, 2)
        W, q = np.eye(4), np.full((2, 2), -1.0)
        first = solver.solve(W, q, 0.5, contacts=[7, 8])
        for wrong in ([7], [7, 7], [0.5, 1.0], [[7, 8]]):
            with self.assertRaises(ValueError):
                solver.solve(W, q, 0.5, contacts=wrong)
        with self.assertRaises(ValueError):
            solver.solve(np.eye(6), np.full((3, 2), -1.0), 0.5)
        for wrong in ((-1, 2), (2, 4), (2.5, 2)):
            with self.assertRaises(ValueError):
                delassus.Solver(*wrong)
        with self.assertRaises(TypeError):
            copy.copy(solver)
        np.testing.assert_array_equal(solver.solve(W, q, 0.5, contacts=[8, 7]).r, first.r)


class Lcp(unittest.TestCase):
    def test_dense_and_sparse(self):
        rng = np.random.default_rng(3)
        for trial in range(20):
            n = 60
            M = sp.random(n, n, 0.05, random_state=trial, data_rvs=lambda k: rng.uniform(-1, 1, k)) + 5 * sp.eye(n)
            q = rng.uniform(-1, 1, n)
            s, dense = delassus.solve_lcp(M, q), delassus.solve_lcp(M.toarray(), q)
            self.assertEqual((s.method, dense.method), ("principal", "lemke"))
            self.assertTrue(s.solved and dense.solved)
            np.testing.assert_allclose(s.z, dense.z, atol=1e-12)
            np.testing.assert_allclose(s.y, M @ s.z + q, atol=1e-14)
            self.assertLess(abs(np.minimum(s.z, s.y)).max(), 1e-12)
            np.testing.assert_array_equal(delassus.solve_lcp(M, q, z0=s.z).z, s.z)
            self.assertEqual(delassus.solve_lcp(M, q, method="lemke").method, "lemke")
            np.testing.assert_allclose(delassus.solve_lcp(M.toarray(), q, method="principal").z, s.z, atol=1e-12)

    def test_no_solution(self):
        s = delassus.solve_lcp([[1.0, 0.0], [0.0, -1.0]], [0.0, -1.0])
        self.assertFalse(s.solved)
        self.assertEqual(s.status, delassus.DLS_NO_SOLUTION)
        self.assertTrue((s.proof >= 0).all() and s.proof @ [0.0, -1.0] < 0)
        self.assertFalse(delassus.solve_lcp(sp.csc_matrix((1, 1)), [-1.0]).solved)
        self.assertTrue(delassus.solve_lcp(sp.csc_matrix((1, 1)), [1.0]).solved)

    def test_progress_and_bad_input(self):
        M, q = sp.diags([2.1, -1.0, -1.0], [0, 1, -1], (50, 50)), np.cos(np.arange(50.0))
        seen = []
        s = delassus.solve_lcp(M, q, progress=lambda p: seen.append(p) or True)
        self.assertEqual(s.status, delassus.DLS_CANCELLED)
        self.assertEqual(seen[0].method, "principal")
        self.assertEqual(delassus.solve_lcp(M, q, max_iterations=1, tol=1e-14).iterations, 1)
        for wrong in (dict(M=sp.eye(3)), dict(q=[1.0]), dict(method="newton"),
                      dict(z0=[1.0]), dict(tol=-1.0), dict(M=[[1.0]]), dict(q=q * np.nan)):
            with self.assertRaises(ValueError, msg=wrong.keys()):
                delassus.solve_lcp(**{**dict(M=M, q=q), **wrong})


class Files(unittest.TestCase):
    """Matrices as other codes write them."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        random = np.random.default_rng(7)
        A = sp.random(60, 60, 0.1, random_state=random, format="csc")
        self.K = (A + A.T + sp.eye(60) * 4).tocsc()

    def tearDown(self):
        self.folder.cleanup()

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def same(self, name, **settings):
        read = delassus.read_matrix(self.path(name), **settings)
        self.assertEqual(read.shape, self.K.shape)
        self.assertEqual(abs(read - self.K).max(), 0, name)

    def test_scipy(self):
        for kind in ("csc", "csr", "coo"):
            for packed in (True, False):
                sp.save_npz(self.path("K.npz"), self.K.asformat(kind), compressed=packed)
                self.same("K.npz")
        scipy.io.hb_write(self.path("K.rua"), self.K)
        back = delassus.read_matrix(self.path("K.rua"))
        np.testing.assert_allclose(back.toarray(), self.K.toarray(), rtol=1e-14)
        scipy.io.mmwrite(self.path("K.mtx"), self.K, precision=17)
        self.same("K.mtx")
        np.save(self.path("K.npy"), self.K.toarray())
        self.same("K.npy")
        # long runs, of which deflate makes short ones
        eye = sp.eye(20000, format="csc")
        sp.save_npz(self.path("I.npz"), eye)
        self.assertEqual(abs(delassus.read_matrix(self.path("I.npz")) - eye).max(), 0)

    def test_triplets(self):
        c = self.K.tocoo()
        for base in (0, 1):
            np.savetxt(self.path("K.txt"), np.c_[c.row + base, c.col + base, c.data],
                       fmt="%d %d %.17g")
            self.same("K.txt", triplets=True)
        matrix, rows = delassus.read_matrix(self.path("K.txt"), triplets=True, labels=True)
        self.assertIsNone(rows)

    def test_labels(self):
        with open(self.path("job_STIF1.mtx"), "w", encoding="utf-8") as file:
            file.write("3,1, 3,1, 2.\n3,2, 3,1, -1.\n3,2, 3,2, 2.\n")
        matrix, rows = delassus.read_matrix(self.path("job_STIF1.mtx"), labels=True)
        np.testing.assert_array_equal(matrix.toarray(), [[2, -1], [-1, 2]])
        np.testing.assert_array_equal(rows, [[3, 1], [3, 2]])

    def test_messages(self):
        scipy.io.savemat(self.path("K.mat"), {"K": self.K})
        sp.save_npz(self.path("K.npz"), sp.dia_matrix(np.eye(3)))
        for name, says in (("K.mat", "triplets=True"), ("K.npz", "K.tocsc()"),
                           ("none", "does not exist")):
            with self.assertRaises(delassus.Error) as caught:
                delassus.read_matrix(self.path(name))
            self.assertIn(says, str(caught.exception))
            self.assertNotIn("dls_", str(caught.exception))


class Words(unittest.TestCase):
    """What mistakes are answered, and what objects say of themselves."""

    def test_mistakes(self):
        K, HN, HT = POINT
        R = delassus.reduce(K, HN, HT)
        mistakes = (
            (lambda: R.solve(0.2, method="newtn"), "did you mean 'newton'"),
            (lambda: R.solve(0.2, method="NLGS"), "did you mean 'nlgs'"),
            (lambda: R.solve(0.2, acceleration="andersn"), "did you mean 'anderson'"),
            (lambda: delassus.reduce(K, HN, HT, factorization="cholsky"), "did you mean 'cholesky'"),
            (lambda: delassus.Motion(K, HN, HT, law="Path"), "did you mean 'path'"),
            (lambda: delassus.solve(np.eye(2), [-1, np.nan], 0.2), "^q\\[1\\]: is not finite"),
            (lambda: delassus.reduce(sp.csc_matrix([[1, 0], [0, np.nan]]), HN, HT), "^K\\[1\\]: is"),
            (lambda: R.solve(0.2, r0=[[np.nan, 1]]), "^r0\\[0\\]: is not finite"),
            (lambda: R.solve([0.2, 0.3]), "mu has 2 entries, needs 1"),
            (lambda: delassus.reduce(K, HN).solve(0.2), "HT is missing"))
        for mistake, answer in mistakes:
            with self.assertRaisesRegex(ValueError, answer):
                mistake()

    def test_notes(self):
        K, HN, HT = POINT
        R = delassus.reduce(K, HN, HT)
        f, g = [5, -10], [0.1, 0]
        self.assertEqual(R.solve(0.2).notes, ["no loads: f is not given"])
        self.assertEqual(R.solve(0.2, f=f, g=g).notes, [])
        self.assertEqual(R.solve(0.2).notes, ["f and g are those of the load before"])
        self.assertIn("gaps are 0", R.solve(0.2, f=f).notes[0])
        self.assertEqual(R.solve(f=f).notes, ["no friction: mu is not given"])
        R.load(f)
        self.assertEqual(R.solve(0.2).notes, [])
        smooth = delassus.reduce(K, HN).solve(f=f)
        self.assertEqual(smooth.notes, ["no friction: HT is not given"])
        self.assertIn("; no friction: HT is not given>", repr(smooth))
        self.assertEqual(list(smooth.states), ["touch"])

    def test_repr(self):
        K, HN, HT = POINT
        R = delassus.reduce(K, HN, HT)
        self.assertEqual(repr(R), "<Reduction: 2D, 1 candidates, 2 unknowns, on W>")
        motion = delassus.Motion(K, HN, HT, law="path")
        self.assertEqual(repr(motion), "<Motion: law path, 2D, 1 candidates, 2 unknowns, 0 steps, "
                                       "t = 0>")
        table = R.solve(0.2, f=[5, -10])._repr_html_()
        self.assertIn("<td>slip</td><td>10.938</td><td>-2.1875</td>", table)
        many = delassus.solve(np.eye(60), -np.ones(60), 0.0, d=2)._repr_html_()
        self.assertEqual(many.count("<tr>"), 21)
        self.assertIn("10 more contacts", many)


class Sums(unittest.TestCase):
    """Reactions on the body: sums by body, moments, a file for ParaView."""

    def two(self, **settings):
        """Two bodies of three nodes in 2D on springs: their middle nodes are pressed."""
        line = sp.diags([2.0, -1.0, -1.0], [0, 1, -1], (3, 3))
        body = sp.kron(line, sp.eye(2))
        K = sp.block_diag([body, body], format="csc")
        N, T = sp.lil_matrix((12, 2)), sp.lil_matrix((12, 2))
        N[3, 0] = N[9, 1] = T[2, 0] = T[8, 1] = 1
        self.f = np.zeros(12)
        self.f[[3, 9, 8]] = -1, -2, 0.3
        return delassus.reduce(K.tocsc(), N.tocsc(), T.tocsc(), **settings)

    def test_by_body(self):
        s = self.two().solve(0.5, f=self.f)
        one, other = s.sums()
        np.testing.assert_allclose(one.force, [s.r[0, 1], s.r[0, 0]])
        np.testing.assert_allclose(other.force, [s.r[1, 1], s.r[1, 0]])
        np.testing.assert_array_equal(other.unknowns, range(6, 12))
        self.assertIsNone(one.moment)
        with self.assertRaisesRegex(ValueError, "coordinates are missing"):
            s.write_vtu("none.vtu")

    def test_moments_and_file(self):
        X = np.array([[0, 0], [1, 0], [2, 0], [10, 1], [11, 1], [12, 1.0]])
        s = self.two(coordinates=X).solve(0.5, f=self.f)
        one, other = s.sums()
        np.testing.assert_allclose(one.moment, [1 * s.r[0, 0]])
        np.testing.assert_allclose(other.moment, [11 * s.r[1, 0] - 1 * s.r[1, 1]])
        with tempfile.TemporaryDirectory() as directory:
            path = os.path.join(directory, "answer.vtu")
            s.write_vtu(path)
            with open(path, encoding="ascii") as file:
                self.assertIn('Name="reaction"', file.read())
            try:
                import meshio
            except ImportError:
                return
            mesh = meshio.read(path)
            np.testing.assert_array_equal(mesh.points[:, :2], X)
            np.testing.assert_array_equal(mesh.point_data["displacement"][:, :2].ravel(), s.x)
            reaction = mesh.point_data["reaction"]
            np.testing.assert_array_equal(reaction[4, :2], [s.r[1, 1], s.r[1, 0]])
            np.testing.assert_array_equal(mesh.point_data["state"].ravel() >= 0,
                                          [False, True, False, False, True, False])

    def test_wrong(self):
        with self.assertRaisesRegex(ValueError, "coordinates is"):
            self.two(coordinates=np.zeros((5, 2)))
        K, HN, _ = POINT
        with self.assertRaisesRegex(ValueError, "HT is not given"):
            delassus.reduce(K, HN).solve(f=[5, -10]).sums()
        with self.assertRaisesRegex(ValueError, "without a reduction"):
            delassus.solve(np.eye(2), [-1, 0.5], 0.3).sums()


class Owners(unittest.TestCase):
    """Objects of Python change only after the library has accepted."""

    def test_update_that_is_refused(self):
        n = 400
        R = delassus.reduce(np.diag(np.full(n, 3.0)), np.eye(n)[:, :1], np.eye(n)[:, 1:2])
        R.load(np.ones(n))
        K, HN, HT = POINT
        for wrong in ((K, HN, HT), (np.eye(n), np.eye(n)[:, :2], np.eye(n)[:, 2:4]),
                      (np.eye(n), np.eye(n)[:, 2:3], np.eye(n)[:, 1:2])):
            with self.assertRaises(delassus.Error):
                R.update(*wrong)
            self.assertEqual((R.n, R.d, R.m, R.candidates), (n, 2, 2, 1))
            self.assertEqual(R.recover([0, 0]).shape, (n,))
            np.testing.assert_allclose(R.q, [[1 / 3, 1 / 3]])
            with self.assertRaises(ValueError):
                R.load([5.0, -10.0])

    def test_update_that_is_refused_keeps_the_host(self):
        K, HN, HT = POINT
        calls = []

        def host(factor):
            def run(B):
                calls.append(factor)
                return np.linalg.solve(factor * K, B)
            return run

        R = delassus.reduce(host(1), HN, HT)
        with self.assertRaises(delassus.Error):
            R.update(host(2), np.ones((2, 1)), np.ones((2, 1)))
        gc.collect()
        R.load([5.0, -10.0])
        np.testing.assert_allclose(R.q, [[-7, 4]], rtol=1e-12)
        self.assertEqual(set(calls), {1})
        R.update(host(2), HN, HT)
        R.load([5.0, -10.0])
        np.testing.assert_allclose(R.q, [[-3.5, 2]], rtol=1e-12)

    def test_later_changes_of_arrays_do_not_matter(self):
        K, HN, HT = chain(40)
        active, mu = np.ones(10, dtype=np.intc), np.full(10, 0.3)
        R = delassus.reduce(K, HN, HT, active=active, mu=mu)
        wanted = R.solve(f=-np.ones(40)).r
        active[:], mu[:] = 0, 0
        np.testing.assert_array_equal(R.solve(f=-np.ones(40)).r, wanted)
        self.assertEqual((R.candidates, R.W.shape), (10, (20, 20)))
        M = sp.csc_matrix(np.eye(40))
        motion = delassus.Motion(K, HN, HT, M=M)
        M.indices[:] = 2**30
        HN.indices[:] = 2**30
        motion.step(-np.ones(40), mu=0.3)
        self.assertTrue(np.isfinite(motion.x).all())

    def test_copies_are_refused(self):
        K, HN, HT = POINT
        for owner in (delassus.reduce(K, HN, HT), delassus.Motion(K, HN, HT, law="path")):
            for make in (copy.copy, copy.deepcopy, pickle.dumps):
                with self.assertRaisesRegex(TypeError, "cannot be copied or pickled"):
                    make(owner)
        s = delassus.reduce(K, HN, HT).solve(0.2, f=[5, -10])
        for other in (copy.deepcopy(s), pickle.loads(pickle.dumps(s))):
            np.testing.assert_array_equal(other.r, s.r)

    def test_errors_are_pickled(self):
        with self.assertRaises(delassus.Error) as caught:
            delassus.solve(np.eye(2), [np.nan, 0], 0.3, d=2)
        e = pickle.loads(pickle.dumps(caught.exception))
        self.assertEqual((str(e), e.argument, e.name), (str(caught.exception), "q",
                                                        "DLS_E_NOT_FINITE"))
        e = pickle.loads(pickle.dumps(delassus.NotCertified(delassus.DLS_STALLED)))
        self.assertEqual((e.status, str(e)[:11]), (delassus.DLS_STALLED, "the contact"))

    def test_random_sequences(self):
        """Calls in any order, good and bad: numbers that were right stay right. The number of calls
        comes from DELASSUS_SEQUENCE (make sequences)."""
        random = np.random.default_rng(4)
        kinds = {"dense": lambda K: K, "sparse": sp.csc_matrix,
                 "host": lambda K: lambda B: np.linalg.solve(K, B)}

        def draw():
            n, d = int(random.integers(3, 9)), int(random.integers(2, 4))
            nodes = int(random.integers(1, n // d + 1))
            A = random.standard_normal((n, n))
            H = np.eye(n)[:, random.permutation(n)[:d * nodes]]
            return A @ A.T + np.eye(n), H[:, :nodes], H[:, nodes:], d

        R, refused = None, 0
        for call in range(int(os.environ.get("DELASSUS_SEQUENCE", 500))):
            if R is None or random.random() < 0.02:
                K, HN, HT, d = draw()
                kind = str(random.choice(list(kinds)))
                R, f = delassus.reduce(kinds[kind](K), HN, HT, d=d), np.zeros(len(K))
            n, m = len(K), d * HN.shape[1]
            what = random.integers(10)
            try:
                if what == 0:
                    K2 = random.uniform(0.5, 2) * K
                    R.update(kinds[kind](K2), HN, HT)
                    K, f = K2, np.zeros(n)
                elif what == 1:
                    K2, HN2, HT2, _ = draw()
                    R.update(kinds[str(random.choice(list(kinds)))](K2), HN2, HT2)
                    self.assertEqual((K2.shape, HT2.shape), (K.shape, HT.shape))
                    K, HN, HT, f = K2, HN2, HT2, np.zeros(n)
                elif what == 2:
                    R.update(lambda B: 1 / 0, HN, HT)
                    self.fail("a host that fails was accepted")
                elif what == 3:
                    f2 = random.standard_normal(n + random.integers(-1, 2))
                    R.load(f2)
                    self.assertEqual(len(f2), n)
                    f = f2
                elif what == 4:
                    s = R.solve(0.3)
                    self.assertEqual((s.r.shape, s.x.shape), ((HN.shape[1], d), (n,)))
                elif what == 5:
                    r = random.standard_normal(m + random.integers(-1, 2))
                    x = R.recover(r)
                    H = np.zeros((n, m))
                    H[:, ::d] = HN
                    for k in range(1, d):
                        H[:, k::d] = HT[:, k - 1::d - 1]
                    np.testing.assert_allclose(K @ x, f + H @ r, atol=1e-8)
                elif what == 6:
                    copy.copy(R)
                elif what == 7:
                    R.load([np.nan] * n)
                elif what == 8:
                    self.assertEqual((R.W.shape, R.q.shape), ((m, m), (HN.shape[1], d)))
                else:
                    R.update(kinds[kind](K * np.nan), HN, HT)
            except (delassus.Error, ValueError, TypeError, ZeroDivisionError) as error:
                refused += 1
                if "holds nothing" in str(error) or isinstance(error, ZeroDivisionError):
                    R = None
                    continue
                self.assertEqual((R.n, R.d, R.m), (n, d, m))
        self.assertGreater(refused, 10)

    def test_random_motions(self):
        """Calls of motions in any order, good and bad: what is refused changes nothing."""
        random = np.random.default_rng(5)

        def wrong(size):
            """Returns an array of another size, or with an entry that is not finite."""
            x = random.standard_normal(size)
            return np.append(x, 1) if random.random() < 0.5 else np.where(x == x.max(), np.nan, x)

        def draw():
            n, d = int(random.integers(3, 9)), int(random.integers(2, 4))
            nodes = int(random.integers(1, n // d + 1))
            H = np.eye(n)[:, random.permutation(n)[:d * nodes]]
            A = random.standard_normal((n, n))
            return n, d, nodes, A @ A.T + np.eye(n), H[:, :nodes], H[:, nodes:]

        def state(motion):
            return [np.array(a) for a in (motion.t, motion.steps, motion.x, motion.v, motion.p,
                                          motion.u, motion.gap, motion.slip)]

        motion, refused, steps = None, 0, 0
        for call in range(int(os.environ.get("DELASSUS_SEQUENCE", 500))):
            if motion is None or random.random() < 0.03:
                n, d, nodes, K, HN, HT = draw()
                law = str(random.choice(["velocity", "gap", "path"]))
                M = None if law == "path" else np.diag(random.uniform(0.5, 2, n))
                kind = random.choice([np.asarray, sp.csc_matrix])
                motion = delassus.Motion(
                    kind(K), HN, HT, M=M, h=1e-2, law=law, max_iterations=200, d=d,
                    theta=1 if law == "gap" else 0.5,
                    gap=random.uniform(0, 0.1, nodes) if random.random() < 0.5 else None)
            before = state(motion)
            what, bad = random.integers(6), random.random() < 0.4
            try:
                if what < 3:
                    arrays = [random.standard_normal(n), 0.1 * random.standard_normal((nodes, d)),
                              random.uniform(0, 1, nodes)]
                    if bad:
                        k = random.integers(3)
                        arrays[k] = wrong((n, d * nodes, nodes)[k])
                    motion.step(*arrays)
                    steps += 1
                elif what == 3:
                    motion.start(wrong(n) if bad else random.standard_normal(n),
                                 None if law == "path" else np.zeros(n), 1.0)
                elif what == 4:
                    motion.set_h(random.choice([0, -1, np.nan, np.inf]) if bad else
                                 random.uniform(1e-3, 1e-2))
                else:
                    copy.copy(motion)
                self.assertFalse(bad)
                self.assertEqual((motion.x.shape, motion.p.shape), ((n,), (nodes, d)))
                self.assertTrue(np.isfinite(motion.x).all())
            except (delassus.Error, delassus.NotCertified, ValueError, TypeError) as error:
                refused += 1
                self.assertTrue(bad or what == 5 or isinstance(error, delassus.NotCertified), error)
                for a, b in zip(before, state(motion)):
                    np.testing.assert_array_equal(a, b)
        self.assertGreater(refused, 10)
        self.assertGreater(steps, 10)


class Signals(unittest.TestCase):
    W = np.array([[1.0, 0, -1, 0], [0, 1, 0, 1], [-1, 0, 1, 0], [0, 1, 0, 1]])

    def long(self, **options):
        """Runs for minutes: no method solves it, and its iterations are many."""
        return delassus.solve(self.W, [-1, 0, -1, 0.0], [0.5, 0.5], d=2, method="nlgs",
                              max_iterations=2**31 - 1, **options)

    def interrupted(self, function, exception=KeyboardInterrupt, number=signal.SIGINT):
        """Returns the seconds from a signal, which comes while function runs, to its exception."""
        sent = []

        def send():
            time.sleep(0.1)
            sent.append(time.perf_counter())
            os.kill(os.getpid(), number)

        thread = threading.Thread(target=send)
        thread.start()
        try:
            with self.assertRaises(exception):
                function()
            return time.perf_counter() - sent[0]
        finally:
            thread.join()

    def test_ctrl_c_ends_a_solve(self):
        for options in ({}, {"history": True}, {"progress": lambda p: False}):
            for _ in range(3):
                self.assertLess(self.interrupted(lambda: self.long(**options)), 1)

    def test_no_signal_is_lost(self):
        """Wherever in the callback the handler runs, what it raises ends the solve."""
        def handler(*_):
            raise TimeoutError

        before = signal.signal(signal.SIGALRM, handler)
        try:
            for k in range(300):
                with self.assertRaises(TimeoutError):
                    signal.setitimer(signal.ITIMER_REAL, 1e-3 + 7e-6 * k)
                    self.long(progress=lambda p: False)
        finally:
            signal.signal(signal.SIGALRM, before)

    def test_ctrl_c_in_a_host(self):
        _, HN, HT = POINT
        K = np.array(POINT[0])
        for _ in range(3):
            R = delassus.reduce(lambda B: np.linalg.solve(K, B), HN, HT)

            def loads():
                for _ in range(10**9):
                    R.load([5.0, -10.0])

            self.assertLess(self.interrupted(loads), 1)
            R.load([5.0, -10.0])
            np.testing.assert_allclose(R.q, [[-7, 4]], rtol=1e-12)

    def test_ctrl_c_in_a_reduction(self):
        side = 1800  # a dense K: some seconds
        K = np.eye(side) * side + np.ones((side, side))
        HN, HT = np.eye(side)[:, ::2], np.eye(side)[:, 1::2]

        def reduce():
            for _ in range(100):
                delassus.reduce(K, HN, HT)

        self.assertLess(self.interrupted(reduce), 2)
        R = delassus.reduce(*POINT)

        def update():
            for _ in range(10**9):
                R.update(*POINT)

        self.assertLess(self.interrupted(update), 1)
        R.update(*POINT)
        np.testing.assert_allclose(R.solve(0.2, f=[5, -10]).x, [0.9375, 0], atol=1e-12)

    def test_other_handlers_are_heard(self):
        def handler(*_):
            raise TimeoutError

        before = signal.signal(signal.SIGUSR1, handler)
        try:
            seconds = self.interrupted(self.long, TimeoutError, signal.SIGUSR1)
        finally:
            signal.signal(signal.SIGUSR1, before)
        self.assertLess(seconds, 1)

    def test_a_thread_needs_no_callback(self):
        answers = []
        W, q = coupled(2, 10)
        thread = threading.Thread(target=lambda: answers.append(delassus.solve(W, q, 0.3)))
        thread.start()
        thread.join()
        np.testing.assert_array_equal(answers[0].r, delassus.solve(W, q, 0.3).r)


class Conversions(unittest.TestCase):
    """What would be another number in C is refused by name."""

    def test_reals(self):
        W, q = coupled(2, 3)
        K, HN, HT = POINT
        R = delassus.reduce(K, HN, HT)
        masked = np.ma.masked_array(q, mask=q > 0)
        for name, call in (
                ("W", lambda x: delassus.solve(x(W), q, 0.3)),
                ("W", lambda x: delassus.solve(x(sp.csc_matrix(W)), q, 0.3)),
                ("q", lambda x: delassus.solve(W, x(q), 0.3)),
                ("mu", lambda x: delassus.solve(W, q, x(np.full(3, 0.3)))),
                ("r0", lambda x: delassus.solve(W, q, 0.3, r0=x(q))),
                ("r", lambda x: delassus.certify(W, q, 0.3, x(q))),
                ("tol", lambda x: delassus.solve(W, q, 0.3, tol=x(np.float64(1e-8)))),
                ("K", lambda x: delassus.reduce(x(K), HN, HT)),
                ("K", lambda x: delassus.reduce(x(sp.csc_matrix(K)), HN, HT)),
                ("HN", lambda x: delassus.reduce(K, x(HN), HT)),
                ("HT", lambda x: delassus.reduce(K, HN, x(HT))),
                ("P", lambda x: delassus.reduce(K, HN, HT, P=x(np.eye(1)))),
                ("K.-1 B", lambda x: delassus.reduce(lambda B: x(np.linalg.solve(K, B)), HN, HT)),
                ("f", lambda x: R.load(x(np.ones(2)))),
                ("g", lambda x: R.load(g=x(np.ones((1, 2))))),
                ("M", lambda x: delassus.Motion(K, HN, HT, M=x(np.eye(2)))),
                ("gap", lambda x: delassus.Motion(K, HN, HT, M=np.eye(2), gap=x(np.ones(1)))),
                ("h", lambda x: delassus.Motion(K, HN, HT, M=np.eye(2), h=x(np.float64(1)))),
                ("theta", lambda x: delassus.Motion(K, HN, HT, M=np.eye(2),
                                                    theta=x(np.float64(1))))):
            with self.assertRaisesRegex(ValueError, f"^{name} holds complex numbers", msg=name):
                call(lambda a: a.astype(complex))
            if name == "W" or name[0] == "K":
                continue
            for kind in (object, str):
                with self.assertRaisesRegex(ValueError, f"^{name} holds", msg=name):
                    call(lambda a: np.asarray(a).astype(kind))
        with self.assertRaisesRegex(ValueError, "^q has masked entries"):
            delassus.solve(W, masked, 0.3)
        for x in ([[1, 2], [3, 4], [5, 6]], q.astype(np.float32), np.ma.masked_array(q)):
            self.assertTrue(delassus.solve(W, x, 0.3).solved)

    def test_integers(self):
        W, q = coupled(2, 3)
        for name in ("max_iterations", "threads", "facets", "positive_definite"):
            for wrong in (2**40, 2**31, -2**31 - 1, 10**30, 2.0, 1.5, "3", None.__class__, [1]):
                with self.assertRaisesRegex(ValueError, f"^{name} ", msg=wrong):
                    delassus.solve(W, q, 0.3, **{name: wrong})
        with self.assertRaisesRegex(delassus.Error, "max_iterations"):
            delassus.solve(W, q, 0.3, max_iterations=-1)
        self.assertTrue(delassus.solve(W, q, 0.3, max_iterations=np.int64(1000)).solved)
        K, HN, HT = POINT
        for wrong in (2**40, 1.5, 4):
            with self.assertRaises(ValueError):
                delassus.reduce(K, HN, HT, d=wrong)
            with self.assertRaises(ValueError):
                delassus.solve(W, q, 0.3, d=wrong)
        for wrong in ([0.5], ["1"], [None], [np.nan]):
            with self.assertRaisesRegex(ValueError, "^active holds"):
                delassus.reduce(K, HN, HT, active=wrong)
        self.assertEqual(delassus.reduce(K, HN, HT, active=[2**40 > 0]).candidates, 1)
        with self.assertRaisesRegex(ValueError, "^body holds"):
            delassus.solve((np.zeros((3, 2)) + 0.5, np.ones((3, 2, 2, 3))), q, 0.3)

    def test_shapes(self):
        W, q = coupled(2, 3)
        for wrong in (dict(q=q.T), dict(r0=q.T), dict(q=q, d=3)):
            with self.assertRaises(ValueError, msg=wrong):
                delassus.solve(**{"W": W, "q": q, "mu": 0.3, "d": 2, **wrong})
        _, HN, HT = POINT
        with self.assertRaisesRegex(ValueError, "K.-1 B is"):
            delassus.reduce(lambda B: B.reshape(-1), np.eye(2), np.eye(2))
        for name in ("nlgs\0x", 3, b"nlgs"):
            with self.assertRaisesRegex(ValueError, "is none of auto, nlgs"):
                delassus.solve(W, q, 0.3, method=name)


class Gallery(unittest.TestCase):
    def test_notebook(self):
        with open("examples/python/tour.ipynb") as file:
            cells = json.load(file)["cells"]
        program = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
        self.assertGreater(len(program), 5)
        names = {}
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            for cell in program:
                exec(cell, names)
        self.assertIn("q[1]: is not finite", printed.getvalue())
        np.testing.assert_allclose(names["s"].r, [[10.9375, -2.1875]])

    def test_a_larger_wall(self):
        """102 blocks, at whose limit most pivots of a sparse matrix wait for its last front."""
        with open("examples/python/limit.py") as file:
            program = file.read().replace("= 6, 4, 1.0, 0.5, 0.65", "= 12, 8, 1.0, 0.5, 0.3")
        with unittest.mock.patch.object(sys, "argv", ["limit.py"]), \
                contextlib.redirect_stdout(io.StringIO()) as printed:
            exec(compile(program, "limit.py", "exec"), {"__name__": "wall"})
        self.assertIn("102 blocks, 548 contacts", printed.getvalue())
        self.assertIn("True", printed.getvalue())

    def test_pictures(self):
        try:
            import matplotlib  # noqa: F401
        except ModuleNotFoundError:
            skip("pictures of examples/python, no matplotlib")
            return
        names = sorted(name for name in os.listdir("examples/python") if name.endswith(".py"))
        self.assertEqual(len(names), 7)
        with tempfile.TemporaryDirectory() as directory:
            for name in names:
                picture = os.path.join(directory, name + ".png")
                subprocess.run([sys.executable, "examples/python/" + name, picture], check=True,
                               capture_output=True)
                self.assertGreater(os.path.getsize(picture), 5000)
                self.assertTrue(os.path.exists(f"docs/pictures/python-{name[:-3]}.png"))
            self.assertEqual(len(os.listdir(directory)), len(names))


class Library(unittest.TestCase):
    def test_constants_and_types(self):
        self.assertEqual(delassus.DLS_OK, 0)
        self.assertIn("DLS_OK", dir(delassus))
        with self.assertRaises(AttributeError):
            delassus.DLS_NONE_SUCH
        fields = [name for name, _ in _library.structs["dls_certificate"]._fields_]
        self.assertEqual(list(delassus.Certificate._fields), fields)
        self.assertTrue(os.path.exists(os.path.join(os.path.dirname(_library.__file__), "py.typed")))

    def test_script_of_the_readme(self):
        with open("docs/python.md") as readme, open("examples/sheet.py") as example:
            script = readme.read().split("```python\n")[1].split("```")[0]
            self.assertTrue(example.read().endswith(script))
        self.assertEqual(len([line for line in script.splitlines() if line]), 15)

    def test_files_of_the_document(self):
        """Runs the scripts and the command of docs/files.md: the program's answer is the package's, to
        the last digit."""
        program = os.path.abspath(os.path.join(os.path.dirname(_library.lib._name), "delassus"))
        with open("docs/files.md") as document:
            text = document.read()
        scipy_block, h5py_block = [part.split("```")[0] for part in text.split("```python\n")[1:]]
        command = next(line.split()[1:] for line in text.split(scipy_block)[1].splitlines()
                       if line.startswith("delassus solve"))
        before = os.getcwd()
        with tempfile.TemporaryDirectory() as directory:
            os.chdir(directory)
            try:
                exec(scipy_block, {})
                printed = subprocess.run([program, *command, "--quiet"], capture_output=True)
                r = np.genfromtxt("answer/r.csv", delimiter=",", skip_header=1)[3:5]
                x = np.genfromtxt("answer/x.csv", delimiter=",", skip_header=1)[:, 1]
                try:
                    exec(h5py_block, {})
                except ModuleNotFoundError:
                    skip("FCLIB of docs/files.md, no h5py")
                else:
                    solved = subprocess.run([program, "solve", "problem.hdf5", "--quiet"],
                                            capture_output=True)
                    if b"built without HDF5" in solved.stderr:
                        print("left out: FCLIB of docs/files.md, HDF5=0")
                    else:
                        self.assertEqual((solved.returncode, solved.stdout), (0, b"solved\n"))
            finally:
                os.chdir(before)
        self.assertEqual(printed.stdout, b"solved\n")
        K, HN, HT = POINT
        s = delassus.reduce(sp.csc_matrix(K), HN, HT).solve(0.2, f=[5.0, -10.0])
        self.assertEqual((r.tolist(), x.tolist()), (s.r[0].tolist(), s.x.tolist()))

    def test_threads(self):
        K, HN, HT = chain(600)
        K = (K + sp.diags(0.1 * np.ones(599), 1)).tocsc()  # unsymmetric: MUMPS
        wanted = delassus.reduce(K, HN, HT).solve(0.3, f=-np.ones(600))
        answers = [None] * 8

        def run(k):
            for _ in range(3):
                answers[k] = delassus.reduce(K, HN, HT).solve(0.3, f=-np.ones(600))

        threads = [threading.Thread(target=run, args=(k,)) for k in range(8)]
        for t in threads:
            t.start()
        for t in threads:
            t.join()
        for a in answers:
            np.testing.assert_array_equal(a.x, wanted.x)

    def test_other_layout_is_refused(self):
        fields, _, version = _library._read_tables()
        self.assertEqual(version, delassus.__version__)
        name, kind, offset, size, count = fields["dls_limits"][2]
        changes = {"moved": (name, kind, offset + 4, size, count),
                   "renamed": ("other", kind, offset, size, count),
                   "wider": (name, "double", offset, size, count),
                   "of no known type": (name, "quaternion", offset, size, count)}
        for what, row in changes.items():
            changed = dict(fields, dls_limits=[*fields["dls_limits"][:2], row,
                                               *fields["dls_limits"][3:]])
            with self.assertRaises(ImportError, msg=what):
                _library._build(changed)
        longer = (*fields["dls_info"][0][:3], fields["dls_info"][0][3] + 8, 1)
        with self.assertRaises(ImportError):
            _library._build(dict(fields, dls_info=[longer, *fields["dls_info"][1:]]))
        for record in ("dls_error", "dls_field"):
            with self.assertRaises(ImportError):
                _library._build({k: v for k, v in fields.items() if k != record})

    def test_other_library_is_refused(self):
        for library in ("libm.so.6", "/nowhere/libdelassus.so"):
            run = subprocess.run([sys.executable, "-c", "import delassus"], capture_output=True,
                                 env=dict(os.environ, DELASSUS_LIBRARY=library), text=True)
            self.assertEqual(run.returncode, 1)
            self.assertIn("ImportError: delassus: ", run.stderr)

    def test_misspelt_field(self):
        with self.assertRaises(AttributeError):
            _library.structs["dls_limits"]().tolerance = 1


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored where a shell began this in
    # the background
    unittest.main()
