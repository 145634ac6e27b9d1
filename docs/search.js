// The search of the manual, in place of the theme's: a browser starts no worker and reads no JSON
// from a file that was opened without a server.
(function () {
  var shown = document.getElementById("mkdocs-search-results");
  var input = document.getElementById("mkdocs-search-query");
  if (!shown || !input) { return; }
  var here = document.currentScript.src.replace(/main\.js.*$/, "");

  function load(name, then) {
    var script = document.createElement("script");
    script.src = here + name;
    script.onload = then;
    document.head.appendChild(script);
  }

  function element(kind, text) {
    var made = document.createElement(kind);
    made.textContent = text;
    return made;
  }

  function show(index, pages) {
    var words = input.value.trim().toLowerCase().split(/\s+/).filter(Boolean);
    shown.replaceChildren();
    if (!words.length) { return; }
    var found = index.query(function (query) {
      words.forEach(function (word) {
        query.term(word, { boost: 10 });
        query.term(word, { wildcard: lunr.Query.wildcard.TRAILING });
      });
    });
    found.slice(0, 30).forEach(function (hit) {
      var page = pages[hit.ref], article = document.createElement("article");
      var title = document.createElement("h3"), link = element("a", page.title);
      link.href = base_url + "/" + page.location;
      title.appendChild(link);
      article.appendChild(title);
      article.appendChild(element("p", page.text.slice(0, 200)));
      shown.appendChild(article);
    });
    if (!found.length) { shown.appendChild(element("p", "Nothing found.")); }
  }

  load("lunr.js", function () {
    load("search_index.js", function () {
      var pages = {};
      var index = lunr(function () {
        this.ref("location");
        this.field("title", { boost: 20 });
        this.field("text");
        manual_pages.forEach(function (page) {
          pages[page.location] = page;
          this.add(page);
        }, this);
      });
      var asked = new URLSearchParams(location.search).get("q");
      if (asked) { input.value = asked; }
      input.addEventListener("input", function () { show(index, pages); });
      show(index, pages);
    });
  });
})();
