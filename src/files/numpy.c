/*
 * numpy.c: arrays of NumPy (.npy) and sparse matrices of scipy.sparse.save_npz (.npz): a zip file
 * with format, shape, data and indices, indptr (csc, csr) or row, col (coo), each an .npy.
 */
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "files/formats.h"

/* ---- .npy ------------------------------------------------------------------------------------ */

/* The types of numbers: a letter, bytes. */
typedef struct npy_head {
  char letter;
  size_t width;
  int by_columns;
  size_t rows, cols, begin; /* begin: first byte of the numbers */
} npy_head;

static int npy_shape(const char *text, npy_head *head) {
  int size[2] = {1, 1}, count = 0;
  while (*text && *text != ')') {
    if (*text == ',' || *text == ' ')
      text++;
    else if (count == 2 || !dlsi_read_whole(&text, 0, INT_MAX, &size[count++]))
      return 0;
  }
  head->rows = (size_t)size[0];
  head->cols = (size_t)size[1];
  return *text == ')';
}

/* Reads magic, version, length (2 bytes, from version 2 on 4), and a dictionary like
 * {'descr': '<f8', 'fortran_order': False, 'shape': (3, 2), }. */
static int npy_header(const dlsi_bytes *file, npy_head *head) {
  const unsigned char *b = file->at;
  char text[1024] = {0};
  if (file->size < 12 || memcmp(b, "\x93NUMPY", 6) != 0 || b[6] < 1 || b[6] > 3 || b[7]) return 0;
  const size_t fixed = b[6] == 1 ? 10 : 12, length = b[8] + 256u * b[9];
  if ((fixed == 12 && (b[10] || b[11])) || length >= sizeof text || length > file->size - fixed)
    return 0;
  memcpy(text, b + fixed, length);
  head->begin = fixed + length;
  const char *type = strstr(text, "'descr': '"), *order = strstr(text, "'fortran_order': "),
             *shape = strstr(text, "'shape': (");
  if (!type || !order || !shape || !npy_shape(shape + 10, head)) return 0;
  head->letter = type[11];
  const char *width = type + 12;
  int value = 0;
  if (type[10] == '>' || !dlsi_read_whole(&width, 1, 16, &value)) return 0;
  head->width = (size_t)value;
  head->by_columns = strncmp(order + 17, "True", 4) == 0;
  return 1;
}

/* Returns number k of a little-endian array. */
static double npy_number(const npy_head *head, const unsigned char *x, size_t k) {
  const unsigned char *at = x + k * head->width;
  uint64_t bits = 0;
  for (size_t b = 0; b < head->width; b++)
    bits |= (uint64_t)at[b] << (8 * b);
  if (head->letter == 'f' && head->width == 8) {
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
  }
  if (head->letter == 'f') {
    const uint32_t half = (uint32_t)bits;
    float value;
    memcpy(&value, &half, sizeof value);
    return value;
  }
  const uint64_t sign = (uint64_t)1 << (8 * head->width - 1);
  if (head->letter != 'i' || !(bits & sign)) return (double)bits;
  bits |= ~(2 * sign - 1); /* two's complement in 64 bits */
  return -(double)(~bits + 1);
}

dls_status dlsi_npy_read(const dlsi_bytes *file, dlsi_table *t, dls_error *error) {
  npy_head head;
  const int known =
      npy_header(file, &head) && ((head.letter == 'f' && (head.width == 4 || head.width == 8)) ||
                                  (strchr("iub", head.letter) && head.width <= 8));
  if (!known || !head.cols)
    return dlsi_fail(
        error, DLS_E_FORMAT, "path", -1, 0,
        "is no array of real numbers in one or two dimensions: numpy.asarray(K, float) "
        "makes one, a sparse matrix goes by scipy.sparse.save_npz");
  const size_t room = (file->size - head.begin) / head.width;
  if (head.rows > room / head.cols || head.rows * head.cols * head.width != file->size - head.begin)
    return dlsi_fail(error, DLS_E_FORMAT, "path", -1, 0,
                     "holds more or less than %zu x %zu numbers", head.rows, head.cols);
  t->rows = (int)head.rows;
  t->cols = (int)head.cols;
  t->a = dlsi_alloc(head.rows ? head.rows * head.cols : 1, sizeof *t->a);
  if (!t->a) return dlsi_no_memory(error);
  for (size_t i = 0; i < head.rows; i++)
    for (size_t j = 0; j < head.cols; j++)
      t->a[i * head.cols + j] = npy_number(&head, file->at + head.begin,
                                           head.by_columns ? j * head.rows + i : i * head.cols + j);
  return DLS_OK;
}

/* ---- zip ------------------------------------------------------------------------------------- */

static unsigned long get_bytes(const unsigned char *at, int count) {
  unsigned long value = 0;
  for (int k = count; k-- > 0;)
    value = value << 8 | at[k];
  return value & 0xffffffffUL;
}

/* Unpacks deflated bytes (RFC 1951) to exactly to->size. 0: broken; -1: memory. */
static int inflate_whole(const dlsi_bytes *from, const dlsi_bytes *to) {
  z_stream stream = {.next_in = (Bytef *)from->at,
                     .avail_in = (uInt)from->size,
                     .next_out = (Bytef *)to->at,
                     .avail_out = (uInt)to->size};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) return -1;
  const int end = inflate(&stream, Z_FINISH);
  (void)inflateEnd(&stream);
  return end == Z_MEM_ERROR ? -1 : end == Z_STREAM_END && stream.avail_out == 0;
}

/* Unpacks the member of an entry of the zip's directory. *to: new bytes. 0: broken; -1: memory. */
static int unpack_member(const dlsi_bytes *zip, const unsigned char *entry, dlsi_bytes *to) {
  const size_t packed = get_bytes(entry + 20, 4), size = get_bytes(entry + 24, 4);
  const size_t local = get_bytes(entry + 42, 4);
  const unsigned long method = get_bytes(entry + 10, 2);
  if (zip->size < 30 || local > zip->size - 30 || memcmp(zip->at + local, "PK\3\4", 4) != 0)
    return 0;
  const size_t begin =
      local + 30 + get_bytes(zip->at + local + 26, 2) + get_bytes(zip->at + local + 28, 2);
  /* deflate gains a factor of 1032 at most: a claim of more takes no memory */
  if (begin > zip->size || packed > zip->size - begin || size / 1032 > packed ||
      !(method == 8 || (method == 0 && size == packed)))
    return 0;
  unsigned char *bytes = dlsi_alloc(size ? size : 1, 1);
  if (!bytes) return -1;
  const dlsi_bytes from = {zip->at + begin, packed};
  *to = (dlsi_bytes){bytes, size};
  if (method == 0) memcpy(bytes, from.at, size);
  const int whole = method == 0 ? 1 : inflate_whole(&from, to);
  return whole > 0 ? crc32_z(0, bytes, size) == get_bytes(entry + 16, 4) : whole;
}

/* The members of a sparse matrix. */
enum member { FORMAT, SHAPE, DATA, INDICES, INDPTR, ROW, COL, members };
static const char *const member_names[members] = {
    "format.npy", "shape.npy", "data.npy", "indices.npy", "indptr.npy", "row.npy", "col.npy"};

typedef struct archive {
  dlsi_bytes member[members];
  dlsi_table table[members];
  int found;
} archive;

/* Returns the first entry of the directory at the end of the zip, and their *count; or NULL. */
static const unsigned char *find_directory(const dlsi_bytes *zip, size_t *count) {
  for (size_t back = 22; back <= zip->size && back < 22 + 65536; back++) {
    const unsigned char *end = zip->at + zip->size - back;
    if (memcmp(end, "PK\5\6", 4) != 0) continue;
    const size_t begin = get_bytes(end + 16, 4);
    *count = get_bytes(end + 10, 2);
    return begin <= zip->size - back ? zip->at + begin : NULL;
  }
  return NULL;
}

static dls_status unpack_archive(const dlsi_bytes *zip, archive *all, dls_error *error) {
  size_t count = 0;
  const unsigned char *entry = find_directory(zip, &count), *end = zip->at + zip->size;
  for (; entry && count > 0; count--) {
    if (end - entry < 46 || memcmp(entry, "PK\1\2", 4) != 0) return DLS_OK;
    const size_t name = get_bytes(entry + 28, 2);
    const size_t length = 46 + name + get_bytes(entry + 30, 2) + get_bytes(entry + 32, 2);
    if (length > (size_t)(end - entry)) return DLS_OK;
    for (int k = 0; k < members; k++) {
      if (name != strlen(member_names[k]) || memcmp(entry + 46, member_names[k], name) != 0 ||
          all->member[k].at)
        continue;
      const int good = unpack_member(zip, entry, &all->member[k]);
      if (good < 0) return dlsi_no_memory(error);
      if (!good)
        return dlsi_fail(error, DLS_E_FORMAT, "path", -1, 0, "%s in it is broken", member_names[k]);
      const dls_status status =
          k == FORMAT ? DLS_OK : dlsi_npy_read(&all->member[k], &all->table[k], error);
      if (status) return status;
      all->found |= 1 << k;
    }
    entry += length;
  }
  return DLS_OK;
}

/* ---- sparse matrices ------------------------------------------------------------------------- */

/* Returns entry k of a member as an index below `end`; -1 for none. */
static int index_of(const dlsi_table *t, size_t k, int end) {
  const double x = t->a[k];
  return x >= 0 && x < end && x == (int)x ? (int)x : -1;
}

static size_t member_count(const dlsi_table *t) {
  return (size_t)t->rows * (size_t)t->cols;
}

/* Adds the entries of compressed columns, or rows where by_rows. Returns 0 for a broken index. */
static int add_compressed(const archive *all, int by_rows, dlsi_triplets *t) {
  const dlsi_table *p = &all->table[INDPTR], *i = &all->table[INDICES];
  const int outer = by_rows ? t->rows : t->cols, inner = by_rows ? t->cols : t->rows;
  const int entries = (int)member_count(&all->table[DATA]);
  if (member_count(p) != (size_t)outer + 1 || p->a[0] != 0 || p->a[outer] != entries) return 0;
  for (int j = 0; j < outer; j++) {
    const int from = index_of(p, (size_t)j, entries + 1);
    const int to = index_of(p, (size_t)j + 1, entries + 1);
    if (from < 0 || to < from) return 0;
    for (int k = from; k < to; k++) {
      const int other = index_of(i, (size_t)k, inner);
      if (other < 0) return 0;
      dlsi_triplets_add(t, by_rows ? j : other, by_rows ? other : j, all->table[DATA].a[k]);
    }
  }
  return 1;
}

static int add_coordinates(const archive *all, dlsi_triplets *t) {
  for (size_t k = 0; k < member_count(&all->table[DATA]); k++) {
    const int i = index_of(&all->table[ROW], k, t->rows),
              j = index_of(&all->table[COL], k, t->cols);
    if (i < 0 || j < 0) return 0;
    dlsi_triplets_add(t, i, j, all->table[DATA].a[k]);
  }
  return 1;
}

static dls_status take_archive(const archive *all, dlsi_triplets *t, dls_error *error) {
  enum { basic = 1 << FORMAT | 1 << SHAPE | 1 << DATA };
  const int compressed = basic | 1 << INDICES | 1 << INDPTR,
            coordinates = basic | 1 << ROW | 1 << COL;
  const dlsi_bytes *format = &all->member[FORMAT];
  if ((all->found & basic) != basic || format->size < 3)
    return dlsi_fail(error, DLS_E_FORMAT, "path", -1, 0,
                     "holds no matrix of scipy.sparse.save_npz; write an array by numpy.save");
  /* the text ends the member: bytes, or characters of four bytes each */
  const size_t width = format->size > 12 && !format->at[format->size - 1] ? 4 : 1;
  char word[4] = {0};
  for (size_t k = 0; k < 3; k++)
    word[k] = (char)format->at[format->size - (3 - k) * width];
  const int by_columns = strcmp(word, "csc") == 0, by_rows = strcmp(word, "csr") == 0;
  const int places = strcmp(word, "coo") == 0, wanted = places ? coordinates : compressed;
  const dlsi_table *shape = &all->table[SHAPE];
  const size_t entries = member_count(&all->table[DATA]);
  if ((!by_columns && !by_rows && !places) || (all->found & wanted) != wanted)
    return dlsi_fail(error, DLS_E_UNSUPPORTED, "path", -1, 0,
                     "holds a sparse matrix of another kind: save_npz(name, K.tocsc())");
  const int rows = member_count(shape) == 2 ? index_of(shape, 0, INT_MAX) : -1;
  const int cols = member_count(shape) == 2 ? index_of(shape, 1, INT_MAX) : -1;
  const int second = places ? ROW : INDICES, third = places ? COL : INDICES;
  if (rows < 1 || cols < 1 || member_count(&all->table[second]) != entries ||
      member_count(&all->table[third]) != entries)
    return dlsi_fail(error, DLS_E_FORMAT, "path", -1, 0, "its arrays have sizes that do not fit");
  const dls_status status = dlsi_triplets_alloc(rows, cols, entries, t, error);
  if (status) return status;
  if (!(places ? add_coordinates(all, t) : add_compressed(all, by_rows, t)))
    return dlsi_fail(error, DLS_E_FORMAT, "path", -1, 0, "has an index that is out of range");
  return DLS_OK;
}

dls_status dlsi_npz_read(const dlsi_bytes *file, dlsi_triplets *t, dls_error *error) {
  archive all = {.found = 0};
  dls_status status = unpack_archive(file, &all, error);
  if (!status) status = take_archive(&all, t, error);
  for (int k = 0; k < members; k++) {
    free((void *)(uintptr_t)all.member[k].at);
    free(all.table[k].a);
  }
  return status;
}
