for (const range of document.querySelectorAll("input[data-compare]")) {
  const place = document.getElementById(range.dataset.compare);
  const move = () => place.style.setProperty("--at", range.value + "%");
  range.addEventListener("input", move);
  move();
}
