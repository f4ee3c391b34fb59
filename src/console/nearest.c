/* nearest.c: finds the names that a mistyped word may have meant, and answers for it. */
#define _GNU_SOURCE
#include <ctype.h>
#include <string.h>

#include "console.h"
#include "delassus/forming.h"
#include "delassus/moving.h"

enum { longest_word = 40 };

static int smaller(int a, int b) {
  return a < b ? a : b;
}

/* Returns the number of mistakes between two words: letters left out, put in, exchanged, or turned
 * round with the next one (optimal string alignment). Capitals count as small letters. */
static int count_mistakes(const char *a, const char *b) {
  const int m = (int)strlen(a), n = (int)strlen(b);
  int D[longest_word + 1][longest_word + 1];
  if (m > longest_word || n > longest_word) return longest_word;
  for (int i = 0; i <= m; i++)
    for (int j = 0; j <= n; j++) {
      if (i == 0 || j == 0) {
        D[i][j] = i + j;
        continue;
      }
      const int x = tolower((unsigned char)a[i - 1]), y = tolower((unsigned char)b[j - 1]);
      D[i][j] = smaller(D[i - 1][j - 1] + (x != y), 1 + smaller(D[i - 1][j], D[i][j - 1]));
      if (i > 1 && j > 1 && x == tolower((unsigned char)b[j - 2]) &&
          y == tolower((unsigned char)a[i - 2]))
        D[i][j] = smaller(D[i][j], D[i - 2][j - 2] + 1);
    }
  return D[m][n];
}

void nearest_try(nearest *n, const char *name) {
  const size_t length = strlen(n->word);
  const int begins = length > 1 && strncasecmp(name, n->word, length) == 0;
  const int mistakes = begins ? 0 : count_mistakes(n->word, name);
  const int most = length < 6 ? 1 + (length > 2) : (int)length / 3;
  if (mistakes > most || (n->count && mistakes > n->mistakes)) return;
  if (n->count && mistakes < n->mistakes) n->count = 0;
  n->mistakes = mistakes;
  if (n->count < NEAREST_MOST) n->name[n->count++] = name;
}

const char *nearest_words(nearest *n) {
  size_t used = 0;
  n->words[0] = '\0';
  for (int k = 0; k < n->count && used < sizeof n->words; k++)
    used += (size_t)snprintf(n->words + used, sizeof n->words - used, "%s%s%s",
                             k == 0              ? "; did you mean "
                             : k == n->count - 1 ? " or "
                                                 : ", ",
                             n->name[k], k == n->count - 1 ? "?" : "");
  return n->words;
}

typedef const char *(*scene_text)(int);
static const scene_text scene_names[] = {[SCENE_AT_ONCE] = dls_fe_scene_name,
                                         [SCENE_FORMING] = dls_forming_name,
                                         [SCENE_MOVING] = dls_moving_name};
static const scene_text scene_descriptions[] = {[SCENE_AT_ONCE] = dls_fe_scene_description,
                                                [SCENE_FORMING] = dls_forming_description,
                                                [SCENE_MOVING] = dls_moving_description};

/* Returns text k of the scenes of all kinds. */
static const char *scene_find(const scene_text *texts, int k) {
  for (int kind = SCENE_AT_ONCE; kind <= SCENE_MOVING; kind++)
    for (int i = 0; texts[kind](i); i++)
      if (k-- == 0) return texts[kind](i);
  return NULL;
}

const char *scene_name(int k) {
  return scene_find(scene_names, k);
}

const char *scene_description(int k) {
  return scene_find(scene_descriptions, k);
}

scene_kind kind_of_scene(const char *name) {
  for (int kind = SCENE_AT_ONCE; kind <= SCENE_MOVING; kind++)
    for (int k = 0; scene_names[kind](k); k++)
      if (strcmp(scene_names[kind](k), name) == 0) return (scene_kind)kind;
  return NO_SCENE;
}

scene_kind kind_among(int argc, char **argv) {
  for (int k = 1; k < argc; k++)
    if (kind_of_scene(argv[k])) return kind_of_scene(argv[k]);
  return NO_SCENE;
}
