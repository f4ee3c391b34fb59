/*
 * delassus/fe.h: the small finite element module, a library of its own (libdelassus-fe), builds the
 * models of the benchmark scenes. A host code does not link it.
 */
#ifndef DELASSUS_FE_H
#define DELASSUS_FE_H

#include "delassus/reduction.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A mesh of three-node triangles (T3) or of four-node elements (Q4), never of both; owns its
 * arrays. Unknowns of node i: 2 i (x) and 2 i + 1 (y). Every function below that takes a mesh
 * refuses NULL, sizes < 1, values that are not finite and node numbers out of range, naming the
 * field ("xy", "node", ...) and the index. */
typedef struct dls_fe_mesh {
  int nodes;
  double *xy; /* 2 * nodes: x_i, y_i     length */
  int triangles;
  int *node; /* 3 * triangles, counterclockwise */
  int quads;
  int *quad; /* 4 * quads, counterclockwise, convex */
} dls_fe_mesh;

/* Makes *mesh, the rectangle [0, lx] x [0, ly] in nx x ny equal rectangles, each cut into two
 * triangles by the diagonal from its bottom-right to its top-left corner; node i + j (nx+1) stands
 * at (i lx/nx, j ly/ny). Ignores what *mesh held before, and leaves it on error. Release with
 * dls_fe_mesh_free, which zeroes the struct. lx, ly > 0: length. nx, ny >= 1. DLS_E_ARGUMENT,
 * DLS_E_SIZE, DLS_E_MEMORY. */
DLS_API DLS_MUST_USE dls_status dls_fe_mesh_block(dls_fe_mesh *mesh, double lx, double ly, int nx,
                                                  int ny, dls_error *error);
/* Works as dls_fe_mesh_block, with the rectangles themselves as four-node elements. */
DLS_API DLS_MUST_USE dls_status dls_fe_mesh_quads(dls_fe_mesh *mesh, double lx, double ly, int nx,
                                                  int ny, dls_error *error);

/* Frees the arrays of the mesh; NULL is fine. */
DLS_API void dls_fe_mesh_free(dls_fe_mesh *mesh);

/* Computes K (2 nodes x 2 nodes, column-major, leading dimension ldk), the stiffness of linear
 * elasticity in plane strain, small strain, unit thickness, K = sum of the integrals of B^T D B
 * over the elements (four-node ones: 2 x 2 Gauss points); symmetric to the last bit. E > 0, -1 < nu
 * < 1/2. E: force / length^2; K: force / length (per unit thickness). DLS_E_ARGUMENT, also for an
 * element that is flat, clockwise or not convex (index = its place in node or quad); DLS_E_SIZE,
 * DLS_E_NOT_FINITE. Allocates nothing. */
DLS_API DLS_MUST_USE dls_status dls_fe_stiffness(const dls_fe_mesh *mesh, double E, double nu,
                                                 double *K, int ldk, dls_error *error);

/* Computes *of_E = dL/dE and *of_nu = dL/dnu of a loss L through the stiffness alone, from f =
 * dL/df of dls_derive_vjp: -f^T (dK/dE) x, -f^T (dK/dnu) x. f, displacement: 2 nodes, with zeros at
 * the supports. Statuses of dls_fe_stiffness. Allocates nothing. */
DLS_API DLS_MUST_USE dls_status dls_fe_material_gradient(const dls_fe_mesh *mesh, double E,
                                                         double nu, const double *f,
                                                         const double *displacement, double *of_E,
                                                         double *of_nu, dls_error *error);

/* A sparse matrix that owns its arrays: A has both triangles, rows of a column increasing, each
 * place once. Start from {0}; release with dls_fe_matrix_free, which zeroes the struct. */
typedef struct dls_fe_matrix {
  dls_sparse A;
  void *memory; /* of the arrays of A */
} dls_fe_matrix;

/* Frees the arrays of the matrix; NULL is fine. */
DLS_API void dls_fe_matrix_free(dls_fe_matrix *matrix);

/* Computes *K, the stiffness of dls_fe_stiffness as a sparse matrix of the unknowns that `unknown`
 * numbers: unknown[k] is
 * the row and column, 0 .. unknowns-1, of the mesh's unknown k (2 nodes), or -1 where it is
 * supported. Unknowns of the mesh that share a number move together. unknown NULL: all 2 nodes, in
 * order; `unknowns` is then not read. Ignores what *K held before, and leaves it on error.
 * Symmetric to the last bit. Statuses as dls_fe_stiffness; DLS_E_ARGUMENT "unknown", also for a
 * number that no unknown of the mesh has (index = that number); DLS_E_MEMORY. */
DLS_API DLS_MUST_USE dls_status dls_fe_sparse_stiffness(const dls_fe_mesh *mesh, double E,
                                                        double nu, const int *unknown, int unknowns,
                                                        dls_fe_matrix *K, dls_error *error);

typedef enum dls_fe_mass_kind {
  DLS_FE_CONSISTENT = 1, /* integrals of rho N_a N_b, exact */
  DLS_FE_LUMPED = 2      /* their sums over b on the diagonal */
} dls_fe_mass_kind;

/* Computes *M, the mass matrix, numbered as dls_fe_sparse_stiffness numbers K. rho > 0: mass /
 * length^3; M: mass (per unit thickness). Statuses as there. */
DLS_API DLS_MUST_USE dls_status dls_fe_mass(const dls_fe_mesh *mesh, double rho,
                                            dls_fe_mass_kind kind, const int *unknown, int unknowns,
                                            dls_fe_matrix *M, dls_error *error);

/* Adds the traction (tx, ty) on the edge between nodes a and b to f (2 nodes), half to each node.
 * Traction: force / length^2. Looks at the two nodes only. DLS_E_ARGUMENT, DLS_E_NOT_FINITE. */
DLS_API DLS_MUST_USE dls_status dls_fe_edge_load(const dls_fe_mesh *mesh, int a, int b, double tx,
                                                 double ty, double *f, dls_error *error);

/* Computes the stress (3 * elements: xx, yy, xy) of a displacement (2 * nodes), plane strain; of a
 * four-node element at its centre. It must not overlap displacement. Statuses as dls_fe_stiffness.
 * Allocates nothing. */
DLS_API DLS_MUST_USE dls_status dls_fe_stress(const dls_fe_mesh *mesh, double E, double nu,
                                              const double *displacement, double *stress,
                                              dls_error *error);

/* A scene: mesh, supports, loads, contact line, friction, ready for dls_reduction_create. */
typedef struct dls_fe_scene dls_fe_scene;

/* Return names and one-line descriptions of the built-in scenes, index 0 ..; NULL past the last. */
DLS_API const char *dls_fe_scene_name(int index);
DLS_API const char *dls_fe_scene_description(int index);

/* Order in which the loads of a scene are applied. With friction the answer depends on it: the
 * second step starts from the state that the first has left. */
typedef enum dls_fe_order {
  DLS_FE_TOGETHER = 0,  /* one step, as in the paper */
  DLS_FE_TOP_FIRST = 1, /* first the pressure on top, then also the traction on the side */
  DLS_FE_SIDE_FIRST = 2
} dls_fe_order;

/* Settings: call dls_fe_scene_settings_init, then change fields. NULL settings are the defaults,
 * which stand last in each comment. */
typedef struct dls_fe_scene_settings {
  size_t size;        /* set by init; settings without it are refused */
  int nx, ny;         /* rectangles along x and y; 0: the scene's own; 0 */
  double mu;          /* friction; < 0: the scene's own; -1 */
  double E;           /* Young's modulus; 0: the scene's own; 0               force / length^2 */
  double nu;          /* Poisson's ratio, < 1/2; -1: the scene's own; -1 */
  int has_load;       /* 1: top, side and side_top are the loads; 0: the scene's own; 0 */
  double top;         /* pressure on the top edge, downwards                  force / length^2 */
  double side;        /* traction +x on the face x = 0, at its bottom         force / length^2 */
  double side_top;    /* and at its top, linear in between                   force / length^2 */
  dls_fe_order order; /* DLS_FE_TOGETHER */
  double grade; /* the k-th of n nodes from the fixed node along each side stands at (k/n)^grade
                         of the side: above 1 the elements become small there; 0: 1; 0 */
} dls_fe_scene_settings;

/* Sets each field to its default. */
DLS_API void dls_fe_scene_settings_init(dls_fe_scene_settings *settings);

/* Creates the scene `name` with concentrated (weighted = 0) or weighted reactions: *out, NULL on
 * error. The model has a dense K up to 300 unknowns, beyond a sparse one. DLS_E_ARGUMENT if there
 * is no scene of that name or a setting is out of range; DLS_E_SETTINGS, DLS_E_SIZE, DLS_E_MEMORY.
 * */
DLS_API DLS_MUST_USE dls_status dls_fe_scene_create(dls_fe_scene **out, const char *name,
                                                    int weighted, dls_error *error);
DLS_API DLS_MUST_USE dls_status dls_fe_scene_create_with(dls_fe_scene **out, const char *name,
                                                         int weighted,
                                                         const dls_fe_scene_settings *settings,
                                                         dls_error *error);

/* Frees the scene; NULL is fine. */
DLS_API void dls_fe_scene_destroy(dls_fe_scene *scene);

/* Input of the reduction, all owned by the scene. Supported unknowns are taken out of the model,
 * which has fewer unknowns than 2 * nodes of the mesh. */
typedef struct dls_fe_scene_data {
  dls_model model;
  const double *f;  /* model.n                                                force */
  const double *g;  /* 2 * model.nodes                                        length */
  const double *mu; /* candidates */
  const dls_fe_mesh *mesh;
  int candidates;
  const int *contact_node;   /* model.nodes: node of the mesh of each contact node */
  const int *candidate_node; /* candidates: index of its contact node in contact_node */
  double E, nu;              /* of the material, for dls_fe_stress            force / length^2, 1 */
  const double *f_first;     /* model.n: f at the end of the first of two steps; NULL: one step */
  dls_sparse weighting;      /* line nodes x candidates: P, of a concentrated scene, too; its first
                                rows are those of the candidates' nodes, in their order */
  const double *cell;        /* candidates: length of the dual cell, the paper's M      length */
} dls_fe_scene_data;

/* Sets *data to views of the scene, which live as long as it does; all zero if scene is NULL. */
DLS_API void dls_fe_scene_get(const dls_fe_scene *scene, dls_fe_scene_data *data);

/* Copies the model's unknowns x (model.n) into displacement (2 * mesh nodes), with zeros at the
 * supports; it must not overlap x. DLS_E_ARGUMENT, DLS_E_NOT_FINITE. */
DLS_API DLS_MUST_USE dls_status dls_fe_scene_displacement(const dls_fe_scene *scene,
                                                          const double *x, double *displacement,
                                                          dls_error *error);

/* What a file for ParaView shows on a mesh. Start from {0}; each array may be NULL. */
typedef struct dls_fe_fields {
  const double *displacement; /* 2 * nodes                                    length */
  const double *reaction;     /* 2 * nodes, (x, y)                            force */
  const double *stress;       /* 3 * elements: xx, yy, xy of dls_fe_stress    force / length^2 */
  double nu;                  /* Poisson's ratio: zz = nu (xx + yy) in plane strain */
  int candidates;
  const int *node;                /* candidates: node of the mesh */
  const dls_contact_state *state; /* candidates */
  const double *gap, *slip;       /* candidates                               length */
} dls_fe_fields;

/* Writes an unstructured VTK XML file (.vtu, ascii, 17 digits) of the mesh with the point data
 * "displacement" and "reaction", the cell data "stress" (a tensor of nine components), and the
 * point data "contact" (DLS_FREE 0, DLS_SLIP 1, DLS_STICK 2; -1 at nodes without contact), "gap"
 * and "slip" (0 there). Where the host has set a locale, its decimal sign must be the point.
 * DLS_E_ARGUMENT "node", also for a number out of range; DLS_E_FILE: cannot be opened or written to
 * the end; an old file stays as it was. */
DLS_API DLS_MUST_USE dls_status dls_fe_write_fields(const char *path, const dls_fe_mesh *mesh,
                                                    const dls_fe_fields *fields, dls_error *error);

/* A ParaView collection (.pvd) of files in the order of time. */
typedef struct dls_fe_series dls_fe_series;

/* Writes a collection of no file to `path`; *out = NULL on error. DLS_E_ARGUMENT, DLS_E_FILE,
 * DLS_E_MEMORY. */
DLS_API DLS_MUST_USE dls_status dls_fe_series_create(dls_fe_series **out, const char *path,
                                                     dls_error *error);

/* Adds `file`, a name relative to the collection's directory without the characters < > & ", in
 * UTF-8 without controls, at `time`, as part >= 0 of the picture then. The collection on disk is
 * whole after each call: a run that is killed leaves what it had. After an error it is without this
 * file. DLS_E_ARGUMENT, DLS_E_NOT_FINITE, DLS_E_FILE, DLS_E_MEMORY. */
DLS_API DLS_MUST_USE dls_status dls_fe_series_add(dls_fe_series *series, double time, int part,
                                                  const char *file, dls_error *error);

/* Frees the series; its file is whole already. NULL is fine. Returns DLS_OK. */
DLS_API DLS_MUST_USE dls_status dls_fe_series_finish(dls_fe_series *series, dls_error *error);

#ifdef __cplusplus
}
#endif

#endif
