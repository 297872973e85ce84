"use strict";
// A report: everything that it shows stands in its own file.

dress();
begin(JSON.parse(document.getElementById("report").textContent));
