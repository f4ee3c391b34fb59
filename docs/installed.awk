# installed.awk: a document as it is installed: without what <!-- tree --> .. <!-- /tree --> encloses, which names files
# of the source tree.
{
  line = $0
  kept = ""
  had = 0
  while (1) {
    if (!off) {
      at = index(line, "<!-- tree -->")
      if (!at) { kept = kept line; break }
      kept = kept substr(line, 1, at - 1)
      line = substr(line, at + 13)
      off = had = 1
    } else {
      had = 1
      at = index(line, "<!-- /tree -->")
      if (!at) break
      line = substr(line, at + 14)
      off = 0
    }
  }
  if (kept != "" || !had) print kept
}
