/*
 * guide.js: the search of the guide. guideWords (words.js) holds a row [place, title, heading, text] for each section.
 * A section is found if each word of the question begins a word in it. A rare word counts more than a frequent one, a
 * title or heading more than text, and a page is shown once, by its best section. What is not found is asked again
 * with two letters less of its longest word.
 */
function guideSearch(question) {
  const words = question.toLowerCase().match(/[\p{L}\p{N}_]+/gu) || [];
  if (!words.length) return [];
  const ask = words.map(word => new RegExp("(?<![\\p{L}\\p{N}])" + word, "gu"));
  const count = (text, at) => (text.toLowerCase().match(ask[at]) || []).length;
  const rows = guideWords.map(row => ({
    row,
    hits: ask.map((_, k) => [count(row[1], k), count(row[2], k), count(row[3], k)])
  }));
  const rare = ask.map((_, k) => Math.log(1 + rows.length / (1 + rows.filter(r => r.hits[k].some(n => n)).length)));
  const phrase = words.join(" ");
  const best = new Map();
  for (const {row, hits} of rows) {
    if (!hits.every(h => h.some(n => n))) continue;
    let score = 0;
    hits.forEach(([title, heading, text], k) => {
      const length = 1 + row[3].length / 2000;
      score += rare[k] * ((title ? 6 : 0) + (heading ? 5 : 0) + 3 * text / (text + length));
    });
    if (words.length > 1 && row.slice(1).some(text => text.toLowerCase().includes(phrase))) score *= 2;
    if (row[2].toLowerCase() === phrase.replace(/\(\)$/, "") + "()") score += 100; // a function by its name
    score *= row[0].startsWith("struct") ? 0.1 : row[0].startsWith("md_") ? 3 : 1; // a field; the pages of prose first
    const page = row[0].split("#")[0];
    const known = best.get(page);
    if (!known) best.set(page, {row, score, all: score});
    else {
      known.all += score / 4;
      if (score > known.score) known.row = row, known.score = score;
    }
  }
  const longest = words.sort((a, b) => b.length - a.length)[0];
  if (!best.size && longest.length > 3) return guideSearch(question.toLowerCase().replace(longest, longest.slice(0, -2)));
  return [...best.values()].sort((a, b) => b.score + b.all - a.score - a.all).slice(0, 12).map(found => found.row);
}

document.addEventListener("DOMContentLoaded", () => {
  const box = document.getElementById("guide-search"), list = document.getElementById("guide-found");
  if (!box) return;
  const show = () => {
    list.replaceChildren(...guideSearch(box.value).map(([place, title, heading, text]) => {
      const link = document.createElement("a"), name = document.createElement("b"), lines = document.createElement("span");
      const at = Math.max(0, text.toLowerCase().indexOf(box.value.toLowerCase().split(/\s+/)[0]) - 60);
      link.href = place;
      name.textContent = heading ? title + ": " + heading : title;
      lines.textContent = text.slice(at && text.indexOf(" ", at) + 1).slice(0, 160);
      link.append(name, lines);
      return link;
    }));
    if (box.value && !list.children.length) list.textContent = "Nothing found";
  };
  box.addEventListener("input", show);
  box.addEventListener("keydown", key => {
    if (key.key === "Enter" && list.firstElementChild) location.href = list.firstElementChild.href;
    if (key.key === "Escape") box.value = "", show();
  });
  document.addEventListener("keydown", key => {
    if (key.key === "/" && document.activeElement !== box) box.focus(), key.preventDefault();
  });
  document.getElementById("guide-fold").addEventListener("click", () => document.body.classList.toggle("guide-open"));
});
