/* named.c: loads a contact problem by the name of a file or of a scene (race.h). */
#include <string.h>
#include <unistd.h>

#include "race.h"

void shorten(const char *name, char *text, size_t size) {
  const char *slash = strrchr(name, '/');
  (void)snprintf(text, size, "%s", slash ? slash + 1 : name);
  char *dot = strrchr(text, '.');
  if (dot && dot != text) *dot = '\0';
}

/* Returns 1 if it is the name of a scene of the finite element module. */
static int names_scene(const char *name) {
  for (int k = 0; dls_fe_scene_name(k); k++)
    if (strcmp(dls_fe_scene_name(k), name) == 0) return 1;
  return 0;
}

static dls_status named_condense(named *p, dls_error *error) {
  dls_fe_scene_data data;
  dls_fe_scene_get(p->scene, &data);
  dls_status status = dls_reduction_create(&p->reduction, &data.model, error);
  if (!status) status = dls_reduction_load(p->reduction, data.f, data.g, error);
  if (!status) status = dls_reduction_contact(p->reduction, data.mu, &p->contact, error);
  return status;
}

dls_status named_load(const char *name, named *p, dls_error *error) {
  shorten(name, p->name, sizeof p->name);
  if (names_scene(name)) {
    dls_status status = dls_fe_scene_create(&p->scene, name, 0, error);
    return status ? status : named_condense(p, error);
  }
  nearest near = {.word = name};
  for (int k = 0; dls_fe_scene_name(k); k++)
    nearest_try(&near, dls_fe_scene_name(k));
  if (access(input_path(name), F_OK) && near.count) {
    *error = (dls_error){.status = DLS_E_FILE};
    (void)snprintf(error->message, sizeof error->message, "no file and no scene%s",
                   nearest_words(&near));
    return DLS_E_FILE;
  }
  if (other_kind(name)) {
    *error = (dls_error){.status = DLS_E_FORMAT};
    (void)snprintf(error->message, sizeof error->message,
                   "a %s, no problem; 'delassus solve --stiffness' takes it, and --out=FILE.hdf5 "
                   "makes a problem of it",
                   other_kind(name));
    return DLS_E_FORMAT;
  }
  const dls_status status = problem_load(name, 0, DLS_ON_W, &p->file, error);
  p->contact = p->file.contact;
  return status;
}

int leave_lcps(int count, char **names) {
  int kept = 0;
  for (int i = 0; i < count; i++) {
    dls_text *text;
    if (read_lcp_text(names[i], &text))
      (void)complain("%s: skipped: an LCP, no contact problem; delassus solve solves it", names[i]);
    else
      names[kept++] = names[i];
    dls_text_destroy(text);
  }
  return kept;
}

void named_free(named *p) {
  dls_reduction_destroy(p->reduction);
  dls_fe_scene_destroy(p->scene);
  problem_free(&p->file);
}
