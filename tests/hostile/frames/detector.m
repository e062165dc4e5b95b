
function found = detection()
    found = struct("label", "box", "corners", [10, 20; 30, 20; 30, 40; 10, 40], "confidence", 0.5);
end
