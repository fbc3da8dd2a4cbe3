"""
A page that turns the shape
===========================

``bilayer view`` writes a result as one HTML file. It needs no network and no program but a browser,
so it can be sent to somebody else.

.. image:: /images/view.png
   :alt: the page of the paper's specimen at a prestretch of 1.24

Two results can lie over each other, the second one see-through:

.. image:: /images/view_two.png
   :alt: the page of two results over each other

"""

# sphinx_gallery_thumbnail_path = 'images/view.png'

import bilayer

specimen = bilayer.paper_specimen().with_milestones([1.03, 1.06, 1.09])
result = bilayer.solve(specimen, "dshell")

# %%
# The page of three shapes takes a tenth of a megabyte; that of the paper's eight takes 0.14 MB.

page = result.bilayer.view()
page.save("dome.html")
print(f"{len(page.text) / 1e6:.2f} MB")
assert len(page.text) < 0.2e6
assert "http" not in page.text.replace("http://www.w3.org", "")  # it loads nothing

# %%
# This is the page itself. Drag it, and move the slider:

page

# %%
# The same shapes as a picture.

figure = bilayer.draw_isometric(result)
bilayer.save_figure(figure, "dome.png")
